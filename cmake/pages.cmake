# SPDX-License-Identifier: MIT
# Man pages and completions of shells, which the tool makes from its option tables: in the folders man/ and completions/ of the build.
file(STRINGS tools/nqm/verbs.c verb_lines REGEX "{\"[a-z]+\", cmd_")
list(TRANSFORM verb_lines REPLACE "^.*{\"([a-z]+)\".*" "\\1" OUTPUT_VARIABLE verbs)
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS tools/nqm/verbs.c)
set(man_dir ${CMAKE_BINARY_DIR}/man)
set(completions_dir ${CMAKE_BINARY_DIR}/completions)
file(MAKE_DIRECTORY ${man_dir} ${completions_dir})
set(man_pages ${man_dir}/nqm.1)
set(commands COMMAND nqm_tool help --format man > ${man_dir}/nqm.1)
foreach(verb IN LISTS verbs)
  list(APPEND man_pages ${man_dir}/nqm-${verb}.1)
  list(APPEND commands COMMAND nqm_tool help --format man ${verb} > ${man_dir}/nqm-${verb}.1)
endforeach()
set(completions ${completions_dir}/nqm ${completions_dir}/_nqm ${completions_dir}/nqm.fish)
list(APPEND commands COMMAND nqm_tool help --format bash > ${completions_dir}/nqm COMMAND nqm_tool help --format zsh > ${completions_dir}/_nqm
  COMMAND nqm_tool help --format fish > ${completions_dir}/nqm.fish)
add_custom_command(OUTPUT ${man_pages} ${completions} ${commands} DEPENDS nqm_tool VERBATIM COMMENT "Man pages and completions")
add_custom_target(pages ALL DEPENDS ${man_pages} ${completions})

install(FILES ${man_pages} DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
install(FILES ${completions_dir}/nqm DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions)
install(FILES ${completions_dir}/_nqm DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/site-functions)
install(FILES ${completions_dir}/nqm.fish DESTINATION ${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d)
