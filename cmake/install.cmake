# What is installed, and where: cmake --install, the target uninstall, find_package(palpa COMPONENTS …).
# The packages that cpack makes of it are in packaging/.
if(NOT PALPA_INSTALL)
  return()
endif()
include(CMakePackageConfigHelpers)

# palpa_must_be_built(COMPONENT FILES file… TARGETS target…): an installation of the component, or of everything, begins with a
# check of what it needs: all of it is installed, or nothing, with the command that is missing.
function(palpa_must_be_built component)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "FILES;TARGETS")
  set(built ${arg_FILES})
  foreach(target IN LISTS arg_TARGETS)
    list(APPEND built "$<$<TARGET_EXISTS:${target}>:$<TARGET_FILE:${target}>>")
  endforeach()
  install(CODE "set(built \"${built}\")
    foreach(file IN LISTS built)
      if(file AND NOT EXISTS \"\${file}\")
        message(FATAL_ERROR \"\${file} is not built yet; first: cmake --build ${PROJECT_BINARY_DIR}\")
      endif()
    endforeach()" COMPONENT ${component})
endfunction()
palpa_must_be_built(library TARGETS palpa palpa_hand)
palpa_must_be_built(development TARGETS palpa_solver palpa palpa_hand)
if(PALPA_VIEW)
  palpa_must_be_built(view_library TARGETS palpa_view palpa_report)
endif()
if(PALPA_APP)
  palpa_must_be_built(program FILES ${PROJECT_BINARY_DIR}/packaging/palpa.1.gz
    TARGETS palpa_cli palpa_pictures palpa_hdf5 palpa-read palpa_net palpa_device_controller palpa_device_force_dimension
      palpa_device_igtl palpa_device_inverse3 palpa_device_openhaptics palpa_device_spacemouse)
endif()
if(PALPA_EXPLORER)
  palpa_must_be_built(explorer TARGETS palpa_explorer_program)
endif()
if(PALPA_PYTHON)
  palpa_must_be_built(python FILES ${PROJECT_BINARY_DIR}/python/palpa/__init__.pyi TARGETS palpa_python)
endif()

# Uninstalling takes away the folders that installing made, and no others: this notes which these are.
configure_file(${CMAKE_CURRENT_LIST_DIR}/note_folders.cmake.in ${PROJECT_BINARY_DIR}/note_folders.cmake @ONLY)
install(SCRIPT ${PROJECT_BINARY_DIR}/note_folders.cmake ALL_COMPONENTS)
configure_file(${CMAKE_CURRENT_LIST_DIR}/uninstall.cmake.in ${PROJECT_BINARY_DIR}/uninstall.cmake @ONLY)
add_custom_target(uninstall COMMAND ${CMAKE_COMMAND} -P ${PROJECT_BINARY_DIR}/uninstall.cmake VERBATIM
  COMMENT "Taking away what was installed")

# palpa_find_libraries(TARGET FOLDER COMPONENT): TARGET finds our libraries from FOLDER, in the build as in an installation,
# wherever that was moved to; to be called after its install(TARGETS). Under /usr the system finds them.
function(palpa_find_libraries target folder component)
  file(RELATIVE_PATH way /prefix/${folder} /prefix/${CMAKE_INSTALL_LIBDIR})
  string(REGEX REPLACE "/$" "" path "$ORIGIN/${way}")
  set_target_properties(${target} PROPERTIES BUILD_WITH_INSTALL_RPATH ON INSTALL_RPATH ${path})
  if(CMAKE_INSTALL_PREFIX STREQUAL "/usr")
    set(installed "\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${folder}/$<TARGET_FILE_NAME:${target}>")
    install(CODE "file(RPATH_REMOVE FILE \"${installed}\")" COMPONENT ${component})
  endif()
endfunction()

# palpa_install_library(NAME TARGET target [PACKAGE library] [DEVELOPMENT development]): a public library, palpa::NAME for
# find_package(palpa COMPONENTS NAME). PACKAGE says into which package a shared one goes, DEVELOPMENT into which what
# find_package reads.
function(palpa_install_library name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "TARGET;PACKAGE;DEVELOPMENT" "")
  if(NOT arg_PACKAGE)
    set(arg_PACKAGE library)
  endif()
  if(NOT arg_DEVELOPMENT)
    set(arg_DEVELOPMENT development)
  endif()
  set_target_properties(${arg_TARGET} PROPERTIES EXPORT_NAME ${name})
  install(TARGETS ${arg_TARGET} EXPORT palpa-${name}
    LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT ${arg_PACKAGE} NAMELINK_COMPONENT development
    ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT development
    INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
  install(EXPORT palpa-${name} NAMESPACE palpa:: FILE palpa-${name}-targets.cmake
    DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/palpa COMPONENT ${arg_DEVELOPMENT})
endfunction()

# palpa_install_header(HEADER PACKAGE): one header, named from palpa/ on.
function(palpa_install_header header package)
  cmake_path(GET header PARENT_PATH folder)
  install(FILES ${PROJECT_SOURCE_DIR}/palpa/${header} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/palpa/${folder}
    COMPONENT ${package})
endfunction()

# palpa_install_headers(HEADER…): public headers, named from palpa/ on. What they include is public, too: install_test.sh
# compiles each of them alone.
function(palpa_install_headers)
  foreach(header IN LISTS ARGN)
    palpa_install_header(${header} development)
  endforeach()
endfunction()

configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/palpa-config.cmake.in ${PROJECT_BINARY_DIR}/palpa-config.cmake
  INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/palpa NO_SET_AND_CHECK_MACRO)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/palpa-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/palpa-config.cmake ${PROJECT_BINARY_DIR}/palpa-config-version.cmake
  DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/palpa COMPONENT development)

# For builds without CMake: pkg-config --cflags --libs palpa, or palpa-hand.
file(RELATIVE_PATH up /prefix/${CMAKE_INSTALL_LIBDIR}/pkgconfig /prefix)
string(REGEX REPLACE "/$" "" up "${up}")
foreach(pc_name palpa palpa-hand)
  configure_file(${CMAKE_CURRENT_LIST_DIR}/palpa.pc.in ${PROJECT_BINARY_DIR}/${pc_name}.pc @ONLY)
endforeach()
install(FILES ${PROJECT_BINARY_DIR}/palpa.pc ${PROJECT_BINARY_DIR}/palpa-hand.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT development)
