# SPDX-License-Identifier: MIT
# nqm.wasm: the scoring chain, fits and small pictures for the page and the module of web/. Included by CMakeLists.txt instead of its
# libraries. NQM_WEB_SOURCES has the sources of expat, jansson, OpenEXR and zlib, which
# web/build.sh unpacks there.
include(cmake/presets.cmake)
set(CMAKE_POSITION_INDEPENDENT_CODE OFF)
set(web ${CMAKE_CURRENT_SOURCE_DIR}/web)
file(GLOB expat ${NQM_WEB_SOURCES}/expat/expat/lib/xmlparse.c ${NQM_WEB_SOURCES}/expat/expat/lib/xmlrole.c
  ${NQM_WEB_SOURCES}/expat/expat/lib/xmltok.c)
file(GLOB jansson ${NQM_WEB_SOURCES}/jansson/src/*.c)
foreach(name adler32 crc32 inflate inffast inftrees zutil deflate trees uncompr)
  list(APPEND zlib ${NQM_WEB_SOURCES}/zlib/${name}.c)
endforeach()
file(GLOB openexr ${NQM_WEB_SOURCES}/openexr/src/lib/OpenEXRCore/*.c)
add_library(nqm_web_parsers STATIC ${expat} ${jansson} ${openexr} ${zlib})
target_include_directories(nqm_web_parsers PUBLIC ${web}/shim ${NQM_WEB_SOURCES}/expat/expat/lib ${NQM_WEB_SOURCES}/jansson/src
  ${NQM_WEB_SOURCES}/openexr/src/lib/OpenEXRCore ${NQM_WEB_SOURCES}/zlib)
target_compile_definitions(nqm_web_parsers PRIVATE HAVE_EXPAT_CONFIG_H HAVE_CONFIG_H)
target_compile_options(nqm_web_parsers PRIVATE -w -Wno-error)

set(nqm_sources src/encode/draw.c)
foreach(room base math kernel io schema material brdf argument net percept sample model lobes metric texture pairs fit translate render label)
  file(GLOB_RECURSE room_sources CONFIGURE_DEPENDS src/${room}/*.c)
  list(APPEND nqm_sources ${room_sources})
endforeach()
# What web/shim replaces, and what a page does not need.
list(FILTER nqm_sources EXCLUDE REGEX
  "/(base/(shared_work|sha256)|io/(zip|mesh.*|raster_(png|jpeg|webp))|kernel/(build_info|isa_a.*)|render/tracer_embree)[.]c$")
list(APPEND nqm_sources tools/figures/picture.c tools/nqm/show/charts.c)
file(GLOB shims CONFIGURE_DEPENDS ${web}/shim/*.c ${web}/src/*.c)
add_executable(nqm_web ${nqm_sources} ${shims} ${NQM_GENERATED_SOURCES} ${NQM_WEB_MODELS})
set_target_properties(nqm_web PROPERTIES OUTPUT_NAME nqm_code SUFFIX .wasm)
target_include_directories(nqm_web PRIVATE ${web}/shim src tools include presets ${CMAKE_BINARY_DIR}/generated)
target_compile_options(nqm_web PRIVATE -O2 -msimd128 -include ${web}/shim/wasi.h -Wno-unknown-pragmas)
set_source_files_properties(src/kernel/isa_generic.c PROPERTIES COMPILE_OPTIONS "-O3;-Wno-psabi")
set_source_files_properties(web/src/api.c PROPERTIES COMPILE_OPTIONS "-Wno-missing-prototypes")
target_link_libraries(nqm_web PRIVATE nqm_web_parsers m)
# 2 GiB: pointers above are negative numbers in JavaScript.
target_link_options(nqm_web PRIVATE -Wl,--max-memory=2147483648 -mexec-model=reactor -Wl,--gc-sections -Wl,--strip-all -Wl,-z,stack-size=1048576)
