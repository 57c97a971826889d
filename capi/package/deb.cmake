# SPDX-License-Identifier: MIT
# cpack makes three Debian packages: the library (named after its SONAME), what building against it takes, and the
# programs with their shapes. Dependencies are read from the binaries; what Debian asks for beside the files of the
# components (copyright, changelog, symbols, compressed manual pages) is added by finish_deb.cmake.
set(DQA_PACKAGE_CONTACT "libdiffaqua authors <libdiffaqua@example.org>" CACHE STRING
  "Maintainer of the Debian packages, as Name <address>: whoever distributes them puts in their own")

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_CONTACT "${DQA_PACKAGE_CONTACT}")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "co-design of soft swimmers by gradient descent")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_RESOURCE_FILE_LICENSE ${PROJECT_SOURCE_DIR}/LICENSE)
set(CPACK_STRIP_FILES ON)
set(CPACK_COMPONENTS_ALL runtime dev)
if(DQA_BUILD_EXAMPLES)
  list(APPEND CPACK_COMPONENTS_ALL programs)
endif()
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${PROJECT_BINARY_DIR})
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(dqa_deb_version ${PROJECT_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE})

set(CPACK_DEBIAN_RUNTIME_PACKAGE_NAME libdiffaqua${dqa_ABI_VERSION})
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SECTION libs)
set(CPACK_COMPONENT_RUNTIME_DESCRIPTION "From a handful of animal meshes to a swimmer whose shape and controller improve
together by gradient descent: a shape space of Wasserstein barycentres, soft
bodies with muscles, water, controllers, and the adjoint of it all.
.
This package contains the shared library.")

set(CPACK_DEBIAN_DEV_PACKAGE_NAME libdiffaqua-dev)
set(CPACK_DEBIAN_DEV_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEV_PACKAGE_SHLIBDEPS OFF)
set(CPACK_DEBIAN_DEV_PACKAGE_DEPENDS "libdiffaqua${dqa_ABI_VERSION} (= ${dqa_deb_version})")
set(CPACK_COMPONENT_DEV_DESCRIPTION "From a handful of animal meshes to a swimmer whose shape and controller improve
together by gradient descent, behind a C interface.
.
This package contains the header, its reference, the CMake package and the
pkg-config file, and the declarations for foreign-function interfaces.")

set(CPACK_DEBIAN_PROGRAMS_PACKAGE_NAME diffaqua)
set(CPACK_DEBIAN_PROGRAMS_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PROGRAMS_PACKAGE_DEPENDS "libdiffaqua${dqa_ABI_VERSION} (= ${dqa_deb_version})")
set(CPACK_DEBIAN_PROGRAMS_PACKAGE_SUGGESTS "gnuplot-nox")
set(CPACK_COMPONENT_PROGRAMS_DESCRIPTION "codesign optimises shape and controller of a swimmer between the meshes of a
few animals, and shows the result in a page for the browser. The experiments of
the DiffAqua paper, a swimmer in the plane and nineteen shapes come with it.")

# Control files: every function exists since the version of its node; no later one has been released yet.
set(dqa_deb_folder ${PROJECT_BINARY_DIR}/deb)
file(STRINGS capi/diffaqua.map dqa_map_lines)
set(dqa_deb_symbols "libdiffaqua.so.${dqa_ABI_VERSION} libdiffaqua${dqa_ABI_VERSION} #MINVER#\n")
set(dqa_node "")
foreach(line IN LISTS dqa_map_lines)
  if(line MATCHES "^(DIFFAQUA_[0-9_]+) ")
    set(dqa_node ${CMAKE_MATCH_1})
    string(APPEND dqa_deb_symbols " ${dqa_node}@${dqa_node} ${PROJECT_VERSION}\n")
  elseif(line MATCHES "^ +(dqa_[a-z0-9_]+)")
    string(APPEND dqa_deb_symbols " ${CMAKE_MATCH_1}@${dqa_node} ${PROJECT_VERSION}\n")
  endif()
endforeach()
file(CONFIGURE OUTPUT ${dqa_deb_folder}/symbols CONTENT "${dqa_deb_symbols}" @ONLY)
file(CONFIGURE OUTPUT ${dqa_deb_folder}/shlibs @ONLY CONTENT
  "libdiffaqua ${dqa_ABI_VERSION} libdiffaqua${dqa_ABI_VERSION} (>= ${PROJECT_VERSION})\n")
file(CONFIGURE OUTPUT ${dqa_deb_folder}/triggers CONTENT "activate-noawait ldconfig\n" @ONLY)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_CONTROL_EXTRA
  "${dqa_deb_folder}/symbols;${dqa_deb_folder}/shlibs;${dqa_deb_folder}/triggers")

# Without CHOLMOD and UMFPACK the binaries are under the licence of their source.
if(DQA_WITH_CHOLMOD)
  set(dqa_deb_gpl "
Comment:
 The source is under the MIT licence. The library of this package is linked with
 CHOLMOD, whose modules Supernodal, Modify and MatrixOps are under the GPL,
 version 2 or later, and with UMFPACK, which is under the same: the binary as a
 whole is therefore distributed under the GPL, version 2 or later. On Debian
 systems the text of version 2 is in /usr/share/common-licenses/GPL-2.")
else()
  set(dqa_deb_gpl "")
endif()
file(READ LICENSE dqa_mit)
string(REGEX MATCH "Copyright[^\n]*" dqa_copyright "${dqa_mit}")
string(REGEX REPLACE "^Copyright *(\\([cC]\\))? *" "" dqa_copyright "${dqa_copyright}")
string(REGEX REPLACE "^.*Copyright[^\n]*\n+" "" dqa_mit "${dqa_mit}")
string(STRIP "${dqa_mit}" dqa_mit)
string(REGEX REPLACE "\n\n" "\n.\n" dqa_mit "${dqa_mit}")
string(REPLACE "\n" "\n " dqa_mit " ${dqa_mit}")
configure_file(capi/package/copyright.in ${dqa_deb_folder}/copyright @ONLY)
string(TIMESTAMP dqa_deb_date "%a, %d %b %Y %H:%M:%S +0000" UTC)  # SOURCE_DATE_EPOCH's where it is set
configure_file(capi/package/changelog.in ${dqa_deb_folder}/changelog @ONLY)
configure_file(CHANGELOG.md ${dqa_deb_folder}/CHANGELOG.md COPYONLY)
configure_file(capi/package/finish_deb.cmake ${dqa_deb_folder}/finish_deb.cmake @ONLY)
set(CPACK_PRE_BUILD_SCRIPTS ${dqa_deb_folder}/finish_deb.cmake)
include(CPack)
