# SPDX-License-Identifier: MIT
# cmake -DOUTPUT=file.c -DINPUTS=a.csv;b.csv -P embed_text.cmake: write the text of each input as a C string literal a line,
# in an array of {name, text} pairs that ends with {NULL, NULL}.
set(code "/* Generated from presets/ by cmake/embed_text.cmake: do not edit. */\n#include \"brdf/presets_data.h\"\n\nconst nqm_preset_table nqm_preset_tables[] = {\n")
foreach(input IN LISTS INPUTS)
  get_filename_component(name ${input} NAME_WE)
  file(READ ${input} text)
  string(REPLACE "\\" "\\\\" text "${text}")
  string(REPLACE "\"" "\\\"" text "${text}")
  string(REPLACE "\n" "\\n\"\n     \"" text "${text}")
  string(APPEND code "    {\"${name}\",\n     \"${text}\"},\n")
endforeach()
string(APPEND code "    {0, 0}};\n")
file(WRITE ${OUTPUT} "${code}")
