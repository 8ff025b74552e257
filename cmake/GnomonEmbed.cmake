# gnomon_embed(FILE VARIABLE SOURCE): writes into SOURCE a C file that defines
# const char VARIABLE[], the text of FILE with a zero at its end. Made again when FILE changes.
function(gnomon_embed file variable source)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${file})
  file(READ ${file} bytes HEX)
  string(REGEX REPLACE "(..)" "'\\\\x\\1'," bytes "${bytes}")
  file(CONFIGURE OUTPUT ${source} @ONLY CONTENT
    "extern const char ${variable}[];\nconst char ${variable}[] = {\n@bytes@ 0};\n")
endfunction()
