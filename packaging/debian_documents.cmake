# Runs when cpack has put together the files of each package: every one gets its copyright and changelog.
foreach(component IN LISTS CPACK_COMPONENTS_ALL)
  # Putting together is no installation: the target uninstall must not take what it lists.
  file(REMOVE ${CPACK_PALPA_BUILD}/install_manifest_${component}.txt)
  string(TOUPPER ${component} upper)
  set(package ${CPACK_DEBIAN_${upper}_PACKAGE_NAME})
  set(folder ${CPACK_TEMPORARY_INSTALL_DIRECTORY}/${component}/usr/share/doc/${package})
  file(MAKE_DIRECTORY ${folder})
  file(COPY ${CPACK_PALPA_SOURCE}/copyright DESTINATION ${folder} FILE_PERMISSIONS OWNER_READ OWNER_WRITE GROUP_READ WORLD_READ)
  string(TIMESTAMP now "%a, %d %b %Y %H:%M:%S +0000" UTC)  # that of SOURCE_DATE_EPOCH where it is set
  set(version ${CPACK_PACKAGE_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE})
  file(WRITE ${folder}/changelog.Debian "palpa (${version}) unstable; urgency=medium

  * Version ${CPACK_PACKAGE_VERSION}; what changed is in the file CHANGELOG.md of libpalpa-dev.

 -- ${CPACK_DEBIAN_PACKAGE_MAINTAINER}  ${now}
")
  execute_process(COMMAND gzip -9nf ${folder}/changelog.Debian COMMAND_ERROR_IS_FATAL ANY)
  execute_process(COMMAND chmod 644 ${folder}/changelog.Debian.gz COMMAND_ERROR_IS_FATAL ANY)
endforeach()
