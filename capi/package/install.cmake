# SPDX-License-Identifier: MIT
# What is installed, by component: runtime (the library), dev (header, CMake package, pkg-config file, declarations for
# foreign-function interfaces, reference), programs (examples/CMakeLists.txt), python (the wheel's; bindings/).
install(TARGETS diffaqua EXPORT diffaqua
  LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT runtime NAMELINK_COMPONENT dev
  RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT runtime)
install(FILES capi/diffaqua.h DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT dev)
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT licence)
install(FILES bindings/diffaqua.cdef DESTINATION ${CMAKE_INSTALL_DATADIR}/diffaqua COMPONENT dev)

set(dqa_cmake_dir ${CMAKE_INSTALL_LIBDIR}/cmake/diffaqua)
install(EXPORT diffaqua FILE diffaquaTargets.cmake NAMESPACE diffaqua:: DESTINATION ${dqa_cmake_dir} COMPONENT dev)
configure_package_config_file(capi/diffaquaConfig.cmake.in diffaquaConfig.cmake INSTALL_DESTINATION ${dqa_cmake_dir})
# Below 1.0 a minor release may break callers.
write_basic_package_version_file(diffaquaConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/diffaquaConfig.cmake ${PROJECT_BINARY_DIR}/diffaquaConfigVersion.cmake
  DESTINATION ${dqa_cmake_dir} COMPONENT dev)

# The .pc file finds its prefix from where it lies, so that an installed tree may be moved.
if(IS_ABSOLUTE "${CMAKE_INSTALL_LIBDIR}")
  set(dqa_pc_prefix ${CMAKE_INSTALL_PREFIX})
  set(dqa_pc_libdir ${CMAKE_INSTALL_LIBDIR})
else()
  file(RELATIVE_PATH dqa_pc_up /prefix/${CMAKE_INSTALL_LIBDIR}/pkgconfig /prefix)
  string(REGEX REPLACE "/$" "" dqa_pc_up "${dqa_pc_up}")
  set(dqa_pc_prefix "\${pcfiledir}/${dqa_pc_up}")
  set(dqa_pc_libdir "\${prefix}/${CMAKE_INSTALL_LIBDIR}")
endif()
if(IS_ABSOLUTE "${CMAKE_INSTALL_INCLUDEDIR}")
  set(dqa_pc_includedir ${CMAKE_INSTALL_INCLUDEDIR})
else()
  set(dqa_pc_includedir "\${prefix}/${CMAKE_INSTALL_INCLUDEDIR}")
endif()
configure_file(capi/diffaqua.pc.in diffaqua.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/diffaqua.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT dev)
