# tread_set_up(target): warnings, sanitizers and coverage of our own targets.
function(tread_set_up target)
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wpedantic -Wshadow -Wconversion
                         -Wno-sign-conversion) # clang counts it to -Wconversion, g++ does not
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
    # False alarms of g++ 12: on `"text" + std::string` (GCC bug 105651), and on a vector member
    # whose default is an initializer list, where two such structs are made in one statement.
    target_compile_options(${target} PRIVATE -Wno-restrict -Wno-dangling-pointer)
  endif()
  # Highway leaves out the newer AVX-512 (Ice Lake, Zen 4: byte permutes and bit counts) unless asked.
  # On 64-bit ARM it would add SVE, whose vectors have no size to keep them in arrays by.
  target_compile_definitions(${target} PRIVATE
    HWY_WANT_AVX3_DL "HWY_DISABLED_TARGETS=(HWY_SVE|HWY_SVE2|HWY_SVE_256|HWY_SVE2_128)")
  if(TREAD_WARNINGS_AS_ERRORS)
    target_compile_options(${target} PRIVATE -Werror)
  endif()
  if(TREAD_SANITIZE)
    # g++ 12 sees uninitialised values in the standard library where it instruments it.
    target_compile_options(${target} PRIVATE -fsanitize=${TREAD_SANITIZE} -fno-omit-frame-pointer
                                             -fno-sanitize-recover=all -Wno-maybe-uninitialized)
    target_link_options(${target} PUBLIC -fsanitize=${TREAD_SANITIZE})
  endif()
  if(TREAD_COVERAGE)
    # Atomic: counts of several threads would else go wrong, below zero even, which gcovr refuses.
    target_compile_options(${target} PRIVATE --coverage -fprofile-update=atomic)
    target_link_options(${target} PUBLIC --coverage)
  endif()
endfunction()

# tread_set_up_tests(target): the same for tests, which run for seconds and are half of what there is
# to compile.
function(tread_set_up_tests target)
  tread_set_up(${target})
  if(CMAKE_BUILD_TYPE STREQUAL "Release")
    target_compile_options(${target} PRIVATE -O1)
  endif()
endfunction()
