# The codecs that are found through pkg-config, as imported targets. Used by the build, and installed
# with it: a program that links the archive needs the same targets.
find_package(PkgConfig REQUIRED)
set(GNOMON_CODEC_MODULES spng libturbojpeg libwebp libcjson OpenEXR
  libavformat libavcodec libswscale libavutil)
set(GNOMON_CODECS "")
foreach(module ${GNOMON_CODEC_MODULES})
  pkg_check_modules(gnomon_${module} REQUIRED IMPORTED_TARGET GLOBAL ${module})
  list(APPEND GNOMON_CODECS PkgConfig::gnomon_${module})
endforeach()
