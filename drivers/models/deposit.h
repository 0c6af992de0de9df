/* Deposit of equal spheres on the floor: runout and height. */
#ifndef NSDAE_MODEL_DEPOSIT_H
#define NSDAE_MODEL_DEPOSIT_H

/* The heap: the largest set of connected spheres, with gaps up to a twentieth of a diameter.
 * Spheres that rolled off alone do not belong to it. */
typedef struct deposit {
  int pile;       /* number of spheres of the heap */
  double radius;  /* mean over sixteen sectors of its outermost rim [m] */
  double scatter; /* standard deviation over the sectors [m] */
  double height;  /* highest centre of its spheres [m] */
  double lowest;  /* lowest centre of all spheres [m]: none may lie in the floor */
} deposit;

/* Measures spheres of radius r at place [n x 3], n >= 1, about the axis x = y = 0. NSDAE_OK or
 * NSDAE_E_MEMORY. */
int deposit_measure(int n, double r, const double *place, deposit *result);

/* Runout (R - R0) / R0 of a column of height a R0, and height H / R0 of what it leaves, as measured
 * on columns of many grains, whatever these were of: sand, salt, sugar, rice, couscous (G. Lube, H.
 * E. Huppert, R. S. J. Sparks, M. A. Hallworth, Axisymmetric collapses of granular columns, J.
 * Fluid Mech. 508, 175-199, 2004). The height up to a = 0.74, below which the top stays, and from
 * 1.7 on; NAN between. */
double deposit_runout(double a);
double deposit_height(double a);

#endif
