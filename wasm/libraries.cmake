# Libraries that consist of headers, in a folder of their own: beside them are headers of the machine that builds.
set(headers ${PROJECT_BINARY_DIR}/headers)
file(MAKE_DIRECTORY ${headers})
foreach(library toml++ nlohmann)
  find_path(PALPA_${library}_PARENT ${library} PATHS /usr/include NO_DEFAULT_PATH REQUIRED)
  file(CREATE_LINK ${PALPA_${library}_PARENT}/${library} ${headers}/${library} SYMBOLIC)
endforeach()
foreach(target PkgConfig::tomlplusplus nlohmann_json::nlohmann_json)
  add_library(${target} INTERFACE IMPORTED GLOBAL)
  target_include_directories(${target} INTERFACE ${headers})
endforeach()
# Libraries of NATIVE sources alone.
foreach(target Threads::Threads ZLIB::ZLIB PkgConfig::blosc)
  add_library(${target} INTERFACE IMPORTED GLOBAL)
endforeach()
# Sizes have 32 bits here; counts of 64 bits were checked against the free memory before.
target_compile_options(palpa_rules INTERFACE -Wno-shorten-64-to-32)
# What the system's own libraries lack, before them.
target_compile_options(palpa_rules INTERFACE -isystem ${PROJECT_SOURCE_DIR}/wasm/std)
