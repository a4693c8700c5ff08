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

# The table of the model rough-plastic, as generated/rough_plastic_table.h.
set(plastic_table ${CMAKE_CURRENT_SOURCE_DIR}/presets/rough_plastic.txt)
set(plastic_h ${CMAKE_BINARY_DIR}/generated/rough_plastic_table.h)
add_custom_command(OUTPUT ${plastic_h}
  COMMAND ${CMAKE_COMMAND} -DOUTPUT=${plastic_h} -DINPUT=${plastic_table}
          -P ${CMAKE_CURRENT_SOURCE_DIR}/cmake/embed_rough_plastic.cmake
  DEPENDS ${plastic_table} ${CMAKE_CURRENT_SOURCE_DIR}/cmake/embed_rough_plastic.cmake VERBATIM)
list(APPEND NQM_GENERATED_SOURCES ${plastic_h})
