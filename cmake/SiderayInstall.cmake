# cmake --install: the libraries, their headers, the program, find_package(sideray) and pkg-config; cpack -G DEB.
include(CMakePackageConfigHelpers)

install(TARGETS sideray_library sideray_scenes_library EXPORT sideray COMPONENT library
  LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(TARGETS sideray RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
if(TARGET sideray_run)
  install(TARGETS sideray_run LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}/sideray)
endif()
if(TARGET sideray-view)
  install(TARGETS sideray-view COMPONENT viewer RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
endif()
install(DIRECTORY include/sideray DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} FILES_MATCHING PATTERN "*.h" PATTERN "*.hpp")
# The snippet and the ready programs, to read and to copy; the library has them too.
install(DIRECTORY shaders/host/ DESTINATION ${CMAKE_INSTALL_DATADIR}/sideray/glsl FILES_MATCHING PATTERN "ready_*.glsl"
  PATTERN snippet EXCLUDE)
install(FILES ${CMAKE_BINARY_DIR}/shaders/sideray.glsl DESTINATION ${CMAKE_INSTALL_DATADIR}/sideray/glsl)
# As they lie here, so that the links from one to the other hold.
install(FILES LICENSE README.md CHANGELOG.md CONTRIBUTING.md SECURITY.md CITATION.cff DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(DIRECTORY docs examples DESTINATION ${CMAKE_INSTALL_DOCDIR} USE_SOURCE_PERMISSIONS
  PATTERN __pycache__ EXCLUDE)

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

# One package for those who compile and run, and one for Python where that is built; `sideray` is of both components that
# are not Python's.
set(CPACK_PACKAGE_NAME sideray)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_ALL library Unspecified)
set(CPACK_COMPONENT_LIBRARY_GROUP sideray)
set(CPACK_COMPONENT_UNSPECIFIED_GROUP sideray)
set(CPACK_DEBIAN_SIDERAY_PACKAGE_NAME sideray)
# The window is a package of its own: `sideray` needs no display and no library of one.
if(TARGET sideray-view)
  list(APPEND CPACK_COMPONENTS_ALL viewer)
  set(CPACK_COMPONENT_VIEWER_GROUP viewer)
  set(CPACK_DEBIAN_VIEWER_PACKAGE_NAME sideray-view)
  set(CPACK_DEBIAN_VIEWER_DESCRIPTION "Window of the Sideray renderer")
  set(CPACK_DEBIAN_VIEWER_PACKAGE_DEPENDS "sideray (= ${PROJECT_VERSION})")
  set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${CMAKE_BINARY_DIR})
endif()
if(TARGET sideray_python)
  list(APPEND CPACK_COMPONENTS_ALL python)
  set(CPACK_COMPONENT_PYTHON_GROUP python)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-sideray)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
  set(CPACK_DEBIAN_PYTHON_DESCRIPTION "Python package of the Sideray renderer")
  # The extension shares the library, and is of one version of Python.
  math(EXPR python_next "${Python3_VERSION_MINOR} + 1")
  string(CONCAT CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS "sideray (= ${PROJECT_VERSION}), python3-numpy, "
    "python3 (>= ${Python3_VERSION_MAJOR}.${Python3_VERSION_MINOR}), "
    "python3 (<< ${Python3_VERSION_MAJOR}.${python_next})")
  # dpkg-shlibdeps finds the library in the package beside it.
  set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${CMAKE_BINARY_DIR})
endif()
set(CPACK_PACKAGE_VENDOR Sideray)
set(CPACK_PACKAGE_CONTACT "The Sideray developers <sideray@localhost>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "raster-first OpenGL renderer with a ray-tracing side service")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION graphics)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
# OpenGL is loaded at run time where it is there, and rays alone draw elsewhere. A bare system has no driver behind libegl1.
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS "libegl1, libgl1-mesa-dri, libosmesa6")
include(CPack)
