/* SPDX-License-Identifier: MIT
 *
 * nqm/nqm.h - all of nqm. libnqm, which scores, holds what base.h, material.h, brdf.h, samples.h, percept.h, model.h and metric.h
 * declare; libnqm-full holds everything.
 */
#ifndef NQM_NQM_H
#define NQM_NQM_H

#include <nqm/base.h>
#include <nqm/brdf.h>
#include <nqm/conform.h>
#include <nqm/corpus.h>
#include <nqm/data.h>
#include <nqm/fit.h>
#include <nqm/label.h>
#include <nqm/library.h>
#include <nqm/match.h>
#include <nqm/material.h>
#include <nqm/metric.h>
#include <nqm/model.h>
#include <nqm/pairs.h>
#include <nqm/percept.h>
#include <nqm/render.h>
#include <nqm/samples.h>
#include <nqm/texture.h>
#include <nqm/train.h>
#include <nqm/translate.h>

#endif
