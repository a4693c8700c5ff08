# SPDX-License-Identifier: MIT
# What `cmake --install` copies: both libraries, shared and static; headers; a pkg-config and a CMake package; the tool, models,
# documentation. Nothing contains the prefix, so that it may be chosen at installation and the folder may be moved.
set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/nqm)
set(documents README.md CHANGELOG.md SECURITY.md LICENSE CITATION.cff)

# `./dev build` makes the tool alone.
install(CODE "if(NOT EXISTS \"$<TARGET_FILE:nqm>\")
  message(FATAL_ERROR \"the libraries are not built: cmake --build ${CMAKE_BINARY_DIR}, then install again\")
endif()")
install(TARGETS nqm_tool RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
if(NQM_SHARED_MODELS)
  set(models_library nqm_models)
  set(models_target nqm::models) # for the static libraries
  set(models_link " -lnqm-models") # the linker looks for libraries of libraries in system folders only
else()
  install(FILES ${full_models} DESTINATION ${CMAKE_INSTALL_DATADIR}/nqm/models)
endif()
install(TARGETS nqm nqm_full ${models_library} EXPORT nqmTargets LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(TARGETS nqm_static nqm_all EXPORT nqmStaticTargets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
foreach(target nqm nqm_full nqm_static nqm_all)
  target_include_directories(${target} INTERFACE $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
endforeach()
install(DIRECTORY include/nqm DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})

# ---- pkg-config and CMake packages ---
# names of libraries for Libs.private, and names of pkg-config modules for the CMake package
foreach(module CRYPTO JANSSON LIBZIP EXPAT ZLIB PNG JPEG WEBP OPENEXR CMINPACK)
  foreach(library IN LISTS ${module}_LIBRARIES)
    string(APPEND private " -l${library}")
  endforeach()
endforeach()
string(APPEND private " ${OpenMP_C_FLAGS} -pthread -ldl -lm")
set(modules libcrypto jansson libzip expat zlib libpng libjpeg libwebp OpenEXR cminpack)
list(JOIN modules " " modules)

function(nqm_pkgconfig name description)
  file(RELATIVE_PATH up /prefix/${CMAKE_INSTALL_LIBDIR}/pkgconfig /prefix)
  string(REGEX REPLACE "/$" "" up "${up}")
  configure_file(cmake/nqm.pc.in ${CMAKE_BINARY_DIR}/${name}.pc @ONLY)
  install(FILES ${CMAKE_BINARY_DIR}/${name}.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
endfunction()
nqm_pkgconfig(nqm "perceived quality of BRDF approximations: score")
nqm_pkgconfig(nqm-full "perceived quality of BRDF approximations: score, train, fit and label")

include(CMakePackageConfigHelpers)
configure_package_config_file(cmake/nqmConfig.cmake.in ${CMAKE_BINARY_DIR}/nqmConfig.cmake INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(${CMAKE_BINARY_DIR}/nqmConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_BINARY_DIR}/nqmConfig.cmake ${CMAKE_BINARY_DIR}/nqmConfigVersion.cmake DESTINATION ${package_dir})
install(EXPORT nqmTargets NAMESPACE nqm:: DESTINATION ${package_dir})
install(EXPORT nqmStaticTargets NAMESPACE nqm:: DESTINATION ${package_dir})

# ---- documentation ---
install(FILES ${documents} DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(DIRECTORY doc DESTINATION ${CMAKE_INSTALL_DOCDIR} FILES_MATCHING PATTERN "*.md" PATTERN "blender.py" PATTERN "*.png" PATTERN "*.svg" PATTERN "*.ipynb")
install(DIRECTORY examples DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(DIRECTORY presets DESTINATION ${CMAKE_INSTALL_DOCDIR} FILES_MATCHING PATTERN "*.csv")
# Links of pages to files that are not installed become plain text.
install(CODE "set(NQM_PAGES \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_DOCDIR}\")")
install(SCRIPT cmake/installed_pages.cmake)
