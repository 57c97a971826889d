# SPDX-License-Identifier: MIT
# The reference as pages for the browser and as the manual page diffaqua(3), both from the header: target `reference`.
# Where doxygen and Python are there, it is built and installed with the rest; elsewhere the header is the reference.
option(DQA_BUILD_REFERENCE "HTML reference and diffaqua(3), where doxygen and Python are there" ${PROJECT_IS_TOP_LEVEL})
if(DQA_BUILD_REFERENCE AND NOT DQA_SANITIZE AND NOT DQA_COVERAGE)
  find_package(Python3 QUIET COMPONENTS Interpreter)
  find_program(dqa_doxygen doxygen)
  mark_as_advanced(dqa_doxygen)
  if(dqa_doxygen AND Python3_EXECUTABLE)
    set(dqa_reference_folder ${PROJECT_BINARY_DIR}/reference)
    file(MAKE_DIRECTORY ${dqa_reference_folder})
    set(dqa_reference_warnings NO)
    if(DQA_WERROR)
      set(dqa_reference_warnings FAIL_ON_WARNINGS)
    endif()
    configure_file(capi/reference/Doxyfile.in ${dqa_reference_folder}/Doxyfile @ONLY)
    set(dqa_read_header ${PROJECT_SOURCE_DIR}/capi/reference/read_header.py)
    add_custom_command(OUTPUT ${dqa_reference_folder}/html/index.html ${dqa_reference_folder}/diffaqua.3
      COMMAND ${CMAKE_COMMAND} -E rm -rf ${dqa_reference_folder}/html
      COMMAND ${dqa_doxygen} ${dqa_reference_folder}/Doxyfile
      COMMAND ${Python3_EXECUTABLE} -B ${dqa_read_header} --manual ${PROJECT_SOURCE_DIR}/capi/diffaqua.h
              ${PROJECT_VERSION} ${dqa_reference_folder}/diffaqua.3
      DEPENDS capi/diffaqua.h capi/reference/guide.md capi/reference/example.c ${dqa_read_header}
              ${dqa_reference_folder}/Doxyfile
      COMMENT "Making the reference of the header"
      VERBATIM)
    add_custom_target(reference ALL DEPENDS ${dqa_reference_folder}/html/index.html ${dqa_reference_folder}/diffaqua.3)
    install(DIRECTORY ${dqa_reference_folder}/html DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT dev)
    install(FILES ${dqa_reference_folder}/diffaqua.3 DESTINATION ${CMAKE_INSTALL_MANDIR}/man3 COMPONENT dev)
  else()
    message(STATUS "No reference is made of the header: doxygen or Python is not there")
  endif()
endif()
