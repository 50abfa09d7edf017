# SPDX-License-Identifier: MIT

# A program must not compile, and the compiler must give the sentence in the comment before its first #include, no
# other sentence of the library, and the name of the program's own file. In the place of a sentence of ours there may be
# the name of a class whose deleted function is called, or of a concept that a callable does not fit.
#   cmake -DSOURCE=... "-DCOMMAND=compiler;arguments" -P check_compile_fail.cmake
file(READ ${SOURCE} program)
string(REGEX MATCH "// must (say|call what is deleted|not fit): ([^#]*)\n#include" sentence "${program}")
set(kind "${CMAKE_MATCH_1}")
string(REPLACE "\n// " " " sentence "${CMAKE_MATCH_2}")
if(sentence STREQUAL "")
    message(FATAL_ERROR "${SOURCE} does not begin with what the compiler must say")
endif()
execute_process(COMMAND ${COMMAND} ${SOURCE} OUTPUT_VARIABLE output ERROR_VARIABLE output RESULT_VARIABLE failed)
if(NOT failed)
    message(FATAL_ERROR "${SOURCE} compiles")
endif()
string(REGEX MATCHALL "error: static[^\n]*lightmesh: [^\n]*" said "${output}")
list(LENGTH said count)
string(FIND "${said}" "${sentence}" place)
set(expected 1)
if(NOT kind STREQUAL "say")
    set(expected 0)
    # clang++ lists all candidates in notes, g++ the constraint.
    set(pattern "error: [^\n]*deleted [^\n]*${sentence}")
    if(kind STREQUAL "not fit")
        set(pattern "error: no matching [^\n]*\n.*${sentence}")
    endif()
    string(REGEX MATCH "${pattern}" found "${output}")
    string(FIND "${found}" "${sentence}" place)
endif()
if(NOT count EQUAL ${expected} OR place EQUAL -1)
    message(FATAL_ERROR "The compiler must say once, and nothing else of ours:\n${sentence}\nIt says:\n${output}")
endif()
get_filename_component(name ${SOURCE} NAME)
string(FIND "${output}" "${name}:" place)
if(place EQUAL -1)
    message(FATAL_ERROR "The compiler does not name the user's own line in ${name}:\n${output}")
endif()
