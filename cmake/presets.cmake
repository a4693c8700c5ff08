# SPDX-License-Identifier: MIT
# Embed the tables of presets/: cmake/embed_text.cmake writes every CSV file of the folder as text to
# generated/presets_data.c at build time. The library parses a table when a preset is requested.
file(GLOB preset_tables CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/presets/*.csv)
set(presets_c ${CMAKE_BINARY_DIR}/generated/presets_data.c)
add_custom_command(OUTPUT ${presets_c}
  COMMAND ${CMAKE_COMMAND} -DOUTPUT=${presets_c} "-DINPUTS=${preset_tables}"
          -P ${CMAKE_CURRENT_SOURCE_DIR}/cmake/embed_text.cmake
  DEPENDS ${preset_tables} ${CMAKE_CURRENT_SOURCE_DIR}/cmake/embed_text.cmake VERBATIM)
list(APPEND NQM_GENERATED_SOURCES ${presets_c})

# The tables of the models rough-plastic, gltf and blender-principled and those of metals, as generated/NAME_table.h.
foreach(name rough_plastic sheen_albedo sheen_ltc principled_energy metals)
  set(table ${CMAKE_CURRENT_SOURCE_DIR}/presets/${name}.txt)
  set(table_h ${CMAKE_BINARY_DIR}/generated/${name}_table.h)
  set(script ${CMAKE_CURRENT_SOURCE_DIR}/cmake/embed_${name}.cmake)
  if(NOT EXISTS ${script})
    set(script ${CMAKE_CURRENT_SOURCE_DIR}/cmake/embed_numbers.cmake)
  endif()
  add_custom_command(OUTPUT ${table_h}
    COMMAND ${CMAKE_COMMAND} -DOUTPUT=${table_h} -DINPUT=${table} -P ${script} DEPENDS ${table} ${script} VERBATIM)
  list(APPEND NQM_GENERATED_SOURCES ${table_h})
endforeach()
