# SPDX-License-Identifier: MIT
VERSION = "0.1.0"  # of the headers that this package follows (include/nqm/base.h)
