/* What is found along curves: Newton's method from places of them, and from their ends. */
#ifndef NSDAE_FRICTION_CURVES_H
#define NSDAE_FRICTION_CURVES_H

#include "chain.h"

/* Curves of more and less compliance, from one place and another, so many steps times items each,
 * and all. 1: solved. */
int nsdae_fc_curves(nsdae_fc_chain *chain, double each, double all);

/* The same of curves that begin next to fc->r, near which a solution may be: one, and others from
 * its end where that is nearer, whatever the caller's bounds. Numbers from 0 on differ in how near
 * a curve is kept. One whose residual is below usual begins so much further down; 0: none does. */
int nsdae_fc_anchored_curves(nsdae_fc_chain *chain, int number, double usual);

#endif
