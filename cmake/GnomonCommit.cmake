cmake_minimum_required(VERSION 3.25)
# Writes OUTPUT, a C file with the commit of the folder SOURCE, "+" behind it where files differ
# from it; only when that has changed.
execute_process(COMMAND git -C ${SOURCE} describe --always --abbrev=12 --dirty=+ --exclude=*
  OUTPUT_VARIABLE commit OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE code)
if(NOT code EQUAL 0 OR NOT commit MATCHES "^[0-9a-f]+[+]?$")
  set(commit unknown)
endif()
file(CONFIGURE OUTPUT ${OUTPUT} @ONLY CONTENT
  "extern const char gn_build_commit[];\nconst char gn_build_commit[] = \"@commit@\";\n")
