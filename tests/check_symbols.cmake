# SPDX-License-Identifier: MIT

# NM: the program. CORE: a library that must define functions whose names begin with lm_ for others, and nothing else.
execute_process(COMMAND ${NM} --dynamic --defined-only ${CORE} OUTPUT_VARIABLE symbols COMMAND_ERROR_IS_FATAL ANY)
string(REGEX MATCHALL "[^\n]+" symbols "${symbols}")
if(NOT symbols MATCHES " T lm_abi")
    message(FATAL_ERROR "${CORE} does not define lm_abi")
endif()
list(FILTER symbols EXCLUDE REGEX " T lm_[a-z_]+$")
if(symbols)
    message(FATAL_ERROR "${CORE} shows: ${symbols}")
endif()
