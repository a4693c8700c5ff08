/* SPDX-License-Identifier: MIT
 *
 * pair_list.h - lists of pairs from memory, for tests and fuzzing; nqm/batch.h has the rest.
 */
#ifndef NQM_SRC_METRIC_PAIR_LIST_H
#define NQM_SRC_METRIC_PAIR_LIST_H

#include "base/base.h"
#include <nqm/batch.h>

/** As nqm_pair_list_load(); `name` is for messages. */
NQM_MUST_CHECK nqm_status nqm_pair_list_parse(const char *text, size_t n_bytes, const char *name,
                                              nqm_pair_list **list_ret, nqm_error *err);

#endif
