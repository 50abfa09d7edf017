# SPDX-License-Identifier: MIT

# A program must not compile, and the compiler must give the sentence in the comment before its first #include, no
# other sentence of the library, and the name of the program's own file.
#   cmake -DSOURCE=... "-DCOMMAND=compiler;arguments" -P check_compile_fail.cmake
file(READ ${SOURCE} program)
string(REGEX MATCH "// must say: ([^#]*)\n#include" sentence "${program}")
string(REPLACE "\n// " " " sentence "${CMAKE_MATCH_1}")
execute_process(COMMAND ${COMMAND} ${SOURCE} OUTPUT_VARIABLE output ERROR_VARIABLE output RESULT_VARIABLE failed)
if(NOT failed)
    message(FATAL_ERROR "${SOURCE} compiles")
endif()
string(REGEX MATCHALL "error: static[^\n]*lightmesh: [^\n]*" said "${output}")
list(LENGTH said count)
string(FIND "${said}" "${sentence}" place)
if(NOT count EQUAL 1 OR place EQUAL -1)
    message(FATAL_ERROR "The compiler must say once, and nothing else of ours:\n${sentence}\nIt says:\n${output}")
endif()
get_filename_component(name ${SOURCE} NAME)
string(FIND "${output}" "${name}:" place)
if(place EQUAL -1)
    message(FATAL_ERROR "The compiler does not name the user's own line in ${name}:\n${output}")
endif()
