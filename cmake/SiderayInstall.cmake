# cmake --install: the libraries, their headers, the program, find_package(sideray) and pkg-config; cpack -G DEB.
include(CMakePackageConfigHelpers)

install(TARGETS sideray_library sideray_scenes_library EXPORT sideray COMPONENT library
  LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(TARGETS sideray RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(DIRECTORY include/sideray DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} FILES_MATCHING PATTERN "*.h" PATTERN "*.hpp")
install(FILES LICENSE README.md DESTINATION ${CMAKE_INSTALL_DOCDIR})

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/sideray)
configure_package_config_file(cmake/sideray-config.cmake.in ${CMAKE_BINARY_DIR}/sideray-config.cmake
  INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(${CMAKE_BINARY_DIR}/sideray-config-version.cmake COMPATIBILITY SameMinorVersion)
install(EXPORT sideray NAMESPACE sideray:: FILE sideray-targets.cmake DESTINATION ${package_dir})
install(FILES ${CMAKE_BINARY_DIR}/sideray-config.cmake ${CMAKE_BINARY_DIR}/sideray-config-version.cmake
  DESTINATION ${package_dir})

# Relative to the file itself, so that the installed tree can be moved.
file(RELATIVE_PATH prefix_from_pc ${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig ${CMAKE_INSTALL_PREFIX})
foreach(name sideray sideray_scenes)
  configure_file(cmake/${name}.pc.in ${CMAKE_BINARY_DIR}/${name}.pc @ONLY)
  install(FILES ${CMAKE_BINARY_DIR}/${name}.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
endforeach()

set(CPACK_PACKAGE_NAME sideray)
set(CPACK_PACKAGE_VENDOR Sideray)
set(CPACK_PACKAGE_CONTACT "The Sideray developers <sideray@localhost>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "raster-first OpenGL renderer with a ray-tracing side service")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION graphics)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
# Loaded at run time, so that no tool finds them.
set(CPACK_DEBIAN_PACKAGE_DEPENDS "libegl1")
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS "libosmesa6")
include(CPack)
