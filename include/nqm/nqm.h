/* SPDX-License-Identifier: MIT
 *
 * nqm/nqm.h - all of nqm. Programs that link libnqm (score and train) need base.h, batch.h, brdf.h, samples.h,
 * metric.h, train.h and human.h only; fit.h, label.h, picture.h, plot.h and bench.h are in
 * libnqm-full.
 */
#ifndef NQM_NQM_H
#define NQM_NQM_H

#include <nqm/base.h>
#include <nqm/batch.h>
#include <nqm/bench.h>
#include <nqm/brdf.h>
#include <nqm/fit.h>
#include <nqm/human.h>
#include <nqm/label.h>
#include <nqm/metric.h>
#include <nqm/picture.h>
#include <nqm/plot.h>
#include <nqm/samples.h>
#include <nqm/train.h>

#endif
