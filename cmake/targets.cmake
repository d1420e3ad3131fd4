# How targets are made: one function for a folder of the library, one for a test, one for a program.

# Warnings and floating-point rules, for all of our own code. Contraction of a*b+c is off so that the
# same session gives the same bits in every build type of one machine.
add_library(palpa_rules INTERFACE)
target_compile_options(palpa_rules INTERFACE
  -Wall -Wextra -Wno-missing-field-initializers -Wshadow -Wconversion -Wno-sign-conversion
  -ffp-contract=off -fno-math-errno)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  # g++ 12 reports the one for "text" + std::string at -O3 (GCC bug 105651), and takes the strings of a moved-from temporary for
  # uninitialised once it is inlined.
  target_compile_options(palpa_rules INTERFACE -Wno-restrict -Wno-maybe-uninitialized)
  # A type of an unnamed namespace in a file that is compiled in a batch is not one of a header.
  if(PALPA_UNITY)
    target_compile_options(palpa_rules INTERFACE -Wno-subobject-linkage)
  endif()
else()
  # std::stable_sort of g++ 12's library, which clang uses, asks for memory by a function that C++20 deprecates.
  target_compile_options(palpa_rules INTERFACE -Wno-deprecated-declarations)
  # In a batch a local name may be one of another file's unnamed namespace, which clang calls shadowing.
  if(PALPA_UNITY)
    target_compile_options(palpa_rules INTERFACE -Wno-shadow)
  endif()
endif()
if(PALPA_SANITIZE)
  target_compile_options(palpa_rules INTERFACE -fsanitize=${PALPA_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=undefined)
  target_link_options(palpa_rules INTERFACE -fsanitize=${PALPA_SANITIZE})
  foreach(sanitizer address thread)  # g++ tells the sources, clang asks for __has_feature
    string(TOUPPER __sanitize_${sanitizer}__ told)
    if(NOT CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND PALPA_SANITIZE MATCHES ${sanitizer})
      target_compile_definitions(palpa_rules INTERFACE ${told}=1)
    endif()
  endforeach()
endif()
target_include_directories(palpa_rules INTERFACE ${PROJECT_SOURCE_DIR})

# palpa_rules_of_c(TARGET): warnings for a program in C; with sanitizers it is linked as the library that it calls.
function(palpa_rules_of_c target)
  set_target_properties(${target} PROPERTIES C_STANDARD 99 C_STANDARD_REQUIRED ON C_EXTENSIONS OFF)
  target_compile_options(${target} PRIVATE -pedantic -Wall -Wextra -Werror)
  if(PALPA_SANITIZE)
    set_target_properties(${target} PROPERTIES LINKER_LANGUAGE CXX)
    target_link_options(${target} PRIVATE -fsanitize=${PALPA_SANITIZE})
  endif()
endfunction()

# palpa_off_tick(TARGET …): targets whose code no tick runs, but for modes in Python, where the interpreter takes the time. At -O1
# they compile in two thirds of the time of -O3, and load, record and draw as fast; at -Oz a page loads sooner.
function(palpa_off_tick)
  foreach(target IN LISTS ARGN)
    target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:$<IF:$<BOOL:${PALPA_WASM}>,-Oz,-O1>>)
  endforeach()
endfunction()

# palpa_layer(NAME SOURCES … NATIVE … LAYERS … LINKS … [OFF_TICK]): one folder of the library. NATIVE are sources that need
# threads, processes, mapped memory or shared objects, which WebAssembly has not (wasm/). LAYERS are the folders it may include,
# so an arrow against the architecture does not link.
# With tests there is a second target, palpa_NAME_unoptimised, for the test that both give the same bits; nothing else builds it.
function(palpa_layer name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "OFF_TICK" "" "SOURCES;NATIVE;LAYERS;LINKS")
  if(NOT PALPA_WASM)
    list(APPEND arg_SOURCES ${arg_NATIVE})
  endif()
  palpa_add_layer(palpa_${name} "")
  if(arg_OFF_TICK)
    palpa_off_tick(palpa_${name})
  endif()
  if(PALPA_TESTS)
    palpa_add_layer(palpa_${name}_unoptimised _unoptimised)
    set_target_properties(palpa_${name}_unoptimised PROPERTIES EXCLUDE_FROM_ALL ON)
    target_compile_options(palpa_${name}_unoptimised PRIVATE -O0)
  endif()
endfunction()

# palpa_add_layer(TARGET SUFFIX): a target of palpa_layer's arguments, on the layers whose targets end in SUFFIX.
macro(palpa_add_layer target suffix)
  if(NOT arg_SOURCES)
    add_library(${target} INTERFACE)
    return()
  endif()
  add_library(${target} STATIC ${arg_SOURCES})
  list(TRANSFORM arg_LAYERS REPLACE "(.+)" "palpa_\\1${suffix}" OUTPUT_VARIABLE layers)
  target_link_libraries(${target} PUBLIC ${layers} PRIVATE $<BUILD_INTERFACE:palpa_rules> ${arg_LINKS})
  # The library's own functions call each other, not what a program may have put in their place: a tick makes hundreds of calls.
  if(NOT PALPA_WASM)
    target_compile_options(${target} PRIVATE -fno-semantic-interposition)
  endif()
  target_include_directories(${target} PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>)
  target_compile_features(${target} PUBLIC cxx_std_20)
endmacro()

# Headers of nearly every test, read once: that was up to a third of the time that a test takes to compile.
function(palpa_test_headers target level)
  file(CONFIGURE OUTPUT ${CMAKE_BINARY_DIR}/tests/headers.cpp CONTENT "int main() {}\n")
  add_executable(${target} ${CMAKE_BINARY_DIR}/tests/headers.cpp)
  target_link_libraries(${target} PRIVATE palpa_rules palpa_solver GTest::gmock)
  target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:${level}>)
  target_precompile_headers(${target} PRIVATE
    <gmock/gmock.h> <gtest/gtest.h> <algorithm> <chrono> <cmath> <filesystem> <fstream> <functional> <map> <memory> <numbers>
    <sstream> <string> <thread> <vector>)
endfunction()

# palpa_test_level(TARGET LEVEL): compiles a test program at -O1 or, half as long, at -O0: floating point is the same at every
# level. Without g++ 12's false alarms about "text" + std::string, as above: in headers of the system they are off, in those that
# were read beforehand they are not.
function(palpa_test_level target level)
  target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:${level}>
    $<$<CXX_COMPILER_ID:GNU>:-Wno-array-bounds> $<$<CXX_COMPILER_ID:GNU>:-Wno-stringop-overflow>)
  target_precompile_headers(${target} REUSE_FROM palpa_test_headers${level})
endfunction()

# palpa_test(NAME SOURCES … LINKS … [DATA] [LOOPS] [PARTS n] [TIMEOUT s] [COST s]): one test program of GoogleTest. ctest runs it
# in PARTS processes, each with its share of the tests: a process for every test would load the libraries thousands of times.
# DATA: some of them use real data. LOOPS: its own code runs long enough to be optimised. COST: [s] of a part on one core. ctest
# begins with the largest, so that no core waits for one long test at the end.
function(palpa_test name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "DATA;LOOPS" "PARTS;TIMEOUT;COST" "SOURCES;LINKS")
  add_executable(test_${name} ${arg_SOURCES})
  target_link_libraries(test_${name} PRIVATE palpa_rules ${arg_LINKS} GTest::gmock GTest::gtest_main)
  if(arg_LOOPS)
    palpa_test_level(test_${name} -O1)
  else()
    palpa_test_level(test_${name} -O0)
  endif()
  set_target_properties(test_${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/tests UNITY_BUILD_BATCH_SIZE 16)
  if(NOT arg_PARTS)
    set(arg_PARTS 1)
  endif()
  if(NOT arg_TIMEOUT)
    set(arg_TIMEOUT 900)
  endif()
  if(NOT arg_COST)
    set(arg_COST 1)
  endif()
  math(EXPR last "${arg_PARTS} - 1")
  set(cases)
  if(arg_DATA)
    # Cases that used the real data in an earlier run (tests/shared_data.h).
    set(noted ${CMAKE_BINARY_DIR}/Testing/data_cases/${name})
    file(MAKE_DIRECTORY ${CMAKE_BINARY_DIR}/Testing/data_cases)
    set(cases "PALPA_TESTS_DATA_CASES=${noted}")
    if(PALPA_HIDE_DATA AND EXISTS ${noted})
      file(STRINGS ${noted} names)
      list(REMOVE_DUPLICATES names)
      list(JOIN names ":" names)
      list(APPEND cases "GTEST_FILTER=${names}")
    endif()
  endif()
  foreach(part RANGE ${last})
    if(arg_PARTS EQUAL 1)
      set(test ${name})
    else()
      set(test ${name}.${part})
    endif()
    add_test(NAME ${test} COMMAND test_${name} --gtest_brief=1)
    set_tests_properties(${test} PROPERTIES TIMEOUT ${arg_TIMEOUT} COST ${arg_COST} ENVIRONMENT
      "PALPA_SHARED=${PALPA_SHARED_FOLDER};PALPA_BIN=${CMAKE_BINARY_DIR}/bin;GTEST_TOTAL_SHARDS=${arg_PARTS};GTEST_SHARD_INDEX=${part};${cases}"
      LABELS "$<$<BOOL:${arg_DATA}>:data>")
  endforeach()
endfunction()
