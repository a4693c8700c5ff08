# SPDX-License-Identifier: MIT
# cmake -DOUTPUT=file.c "-DINPUTS=a.csv;b.csv" -P embed_text.cmake: write the text of each input as C string literals,
# one per line, in a NULL-terminated array of {name, model, doi, text}; and the names of all rows as "TABLE:ROW". The
# model and the DOI are the words that follow "Model" and "DOI" in the comments of the table.
set(tables "")
set(names "")
foreach(input IN LISTS INPUTS)
  get_filename_component(table ${input} NAME_WE)
  file(READ ${input} text)
  string(REGEX MATCHALL "\n[^#,\n]+," rows "${text}")
  list(POP_FRONT rows) # the header
  foreach(row IN LISTS rows)
    string(REGEX REPLACE "[\n,]" "" row "${row}")
    string(APPEND names "    \"${table}:${row}\",\n")
  endforeach()
  string(REGEX MATCH "DOI ([^ \n]+)" doi "${text}")
  set(doi "${CMAKE_MATCH_1}")
  string(REGEX MATCH "Model ([^ .\n]+)" model "${text}")
  set(model "${CMAKE_MATCH_1}")
  string(REPLACE "\\" "\\\\" text "${text}")
  string(REPLACE "\"" "\\\"" text "${text}")
  string(REPLACE "\n" "\\n\"\n     \"" text "${text}")
  string(APPEND tables "    {\"${table}\", \"${model}\", \"${doi}\",\n     \"${text}\"},\n")
endforeach()
file(WRITE ${OUTPUT} "/* Generated from presets/ by cmake/embed_text.cmake: do not edit. */
#include \"brdf/models/presets.h\"

const nqm_preset_table nqm_preset_tables[] = {
${tables}    {0, 0, 0, 0}};

const char *const nqm_preset_names[] = {
${names}};
const size_t nqm_preset_name_count = sizeof nqm_preset_names / sizeof *nqm_preset_names;
")
