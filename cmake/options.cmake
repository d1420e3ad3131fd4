# What is built. A user who adds Palpa to another project gets the library alone.
option(PALPA_READER "Build palpa-read, which opens files (needs VTK, vtk-dicom and ITK)" ${PROJECT_IS_TOP_LEVEL})
option(PALPA_APP "Build the program palpa" ${PROJECT_IS_TOP_LEVEL})
option(PALPA_VIEW "Build pictures, plots and reports (needs VTK with rendering, EGL)" ${PROJECT_IS_TOP_LEVEL})
option(PALPA_DEVICES "Build what talks with real haptic devices (needs Boost)" ${PROJECT_IS_TOP_LEVEL})
option(PALPA_NET "Build what carries hands over a network (needs Boost and OpenSSL)" ${PROJECT_IS_TOP_LEVEL})
option(PALPA_EXPLORER "Build palpa-explorer, the window (needs Qt 5, Qwt and what PALPA_VIEW needs)" OFF)
option(PALPA_PYTHON "Build the Python package palpa (needs pybind11 and numpy)" OFF)
option(PALPA_EXAMPLES "Build the examples" ${PROJECT_IS_TOP_LEVEL})
if(PROJECT_IS_TOP_LEVEL AND (NOT DEFINED BUILD_TESTING OR BUILD_TESTING))
  option(PALPA_TESTS "Build the tests" ON)
else()
  option(PALPA_TESTS "Build the tests" OFF)
endif()
set(PALPA_SHARED_FOLDER ${PROJECT_SOURCE_DIR}/../shared CACHE PATH "The real data that tests use; without it they leave these out")
option(PALPA_HIDE_DATA "Tests find no real data; of programs that ran before only the cases that use them run" OFF)
if(PALPA_HIDE_DATA)
  set(PALPA_SHARED_FOLDER ${CMAKE_BINARY_DIR}/no_data)
endif()
option(PALPA_INSTALL "Make the rules for cmake --install, uninstall and cpack" ${PROJECT_IS_TOP_LEVEL})
option(PALPA_BENCH "Build the benchmarks" OFF)
set(PALPA_SANITIZE "" CACHE STRING "Sanitizers for everything: address,undefined or thread")

# Headers are most of what a file costs to compile: eight files read at once take 0.4 of the time of eight read alone.
option(PALPA_UNITY "Compile the sources of a target in batches of eight" ${PROJECT_IS_TOP_LEVEL})
if(PALPA_UNITY)
  set(CMAKE_UNITY_BUILD ON)
  set(CMAKE_UNITY_BUILD_BATCH_SIZE 8)
endif()
find_program(PALPA_CCACHE ccache)
if(PALPA_CCACHE AND PROJECT_IS_TOP_LEVEL AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  # Headers read beforehand carry a time of their own, which the cache is not to compare.
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env CCACHE_SLOPPINESS=pch_defines,time_macros ${PALPA_CCACHE})
endif()

set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
# Whether this is the module for browsers (preset wasm): the library alone, without threads, files and processes.
string(COMPARE EQUAL "${CMAKE_SYSTEM_PROCESSOR}" wasm32 PALPA_WASM)
if(NOT PALPA_WASM)
  set(CMAKE_POSITION_INDEPENDENT_CODE ON)
  # Against abuse of a fault: programs lie at another address each time, tables of addresses are read-only once a program runs,
  # stacks are not executable. A test reads every file (tests/install/elf_test.sh).
  include(CheckPIESupported)
  check_pie_supported()
  add_link_options(LINKER:-z,relro LINKER:-z,now LINKER:-z,noexecstack)
endif()
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
# The build folder is laid out as an installation, so that programs find our libraries by one relative way in both. CMake's
# own way, to link with one RUNPATH and to exchange it later, pads it with empty elements, which the dynamic linker takes
# as the current folder.
include(GNUInstallDirs)
if(PROJECT_IS_TOP_LEVEL)
  set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bin)
  set(CMAKE_LIBRARY_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/${CMAKE_INSTALL_LIBDIR})
  set(CMAKE_BUILD_RPATH_USE_ORIGIN ON)
endif()
