/* nsdae: everything. BSD-3-Clause. */
#ifndef NSDAE_H
#define NSDAE_H

#include <nsdae/certificate.h>
#include <nsdae/contact.h>
#include <nsdae/kernels.h>
#include <nsdae/lcp.h>
#include <nsdae/friction.h>
#include <nsdae/lcp_file.h>
#include <nsdae/params.h>
#include <nsdae/sim.h>
#include <nsdae/status.h>
#include <nsdae/system.h>
#include <nsdae/trajectory.h>
#include <nsdae/version.h>

#endif
