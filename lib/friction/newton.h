/* Newton's method on an island, and the two methods made of it. */
#ifndef NSDAE_FRICTION_NEWTON_H
#define NSDAE_FRICTION_NEWTON_H

#include "matrix.h"

typedef struct nsdae_fc_newton {
  nsdae_fc *fc;
  nsdae_fc_matrix *matrix;
  double alpha;          /* of the proximal term alpha (r - centre) that is added to u */
  double epsilon;        /* of the smoothed map; 0: the map as it is */
  const double *shift;   /* n: of u_N, in place of mu |u_T|, while epsilon > 0; NULL: none */
  int search;            /* steps are cut short until the map decreases */
  double *centre;        /* 3 n */
  double *E, *A;         /* 9 n: derivatives of the map in r and u, both with the proximal term */
  double *F;             /* 3 n: the map */
  double *dr;            /* 3 n */
  double *trial, *y, *u; /* 3 n, ny, 3 n: a point, and its velocities */
  double *best;          /* 3 n: the point of least residual */
  double *mark;          /* 3 n: a point of the last path, */
  double mark_epsilon;   /* and its epsilon; 0: none */
  double mark_at;        /* epsilon of the next one */
  int steps;             /* done, each with one factorisation */
  int most;              /* allowed */
  int failures;          /* proximal problems that may fail */
} nsdae_fc_newton;

/* Takes the arrays; fc is set before. */
void nsdae_fc_newton_layout(nsdae_fc_newton *newton, nsdae_arena *arena);

/* Half the square of the map at r with velocities u; E and A where derivatives are wanted. */
double nsdae_fc_newton_map(nsdae_fc_newton *newton, const double *r, const double *u,
                           int derivatives);

/* dr [3 n] of b [3 n], by the factors of E and A, refined; neither of them is trial, y or u. */
void nsdae_fc_newton_solve(nsdae_fc_newton *newton, const double *b, double *dr);

/* One step from fc->r, with fc->y and fc->u; before is half the square of the map there. Returns it
 * at the new point; NaN where there is none, and fc as it was. */
double nsdae_fc_newton_step(nsdae_fc_newton *newton, double before);

/* Proximal point method from fc->r on; alpha begins as given. Returns the least residual met, which
 * is that of fc->r then; ends below tol, or after most steps. */
double nsdae_fc_proximal(nsdae_fc_newton *newton, double alpha, double tol);

/* The same for the last digits of a point that is nearly one: where few items are locked, r has to
 * go far along what moves u least, past one kink after the other, and alpha says how far it goes in
 * one problem. So it is held for a while where one failed, longer each time. Ends where so many
 * idle steps have not halved the residual, too. */
double nsdae_fc_creep(nsdae_fc_newton *newton, int idle, double tol);

/* At most so many steps from the solution fc->r on. Each of them that brings the residual down is
 * kept; returns that of fc->r then. */
double nsdae_fc_refine(nsdae_fc_newton *newton, int steps);

/* Follows the path of the smoothed maps from r = 0, epsilon from 1 (or more) down to 1e-6; loose is
 * how far from the path a point may be, relative to epsilon. Ends where the residual is below tol,
 * which is returned. */
double nsdae_fc_path(nsdae_fc_newton *newton, double loose, double tol);

#endif
