/* How closely the contact problem of an island is solved, at what price, and what is accepted in
 * place of it: the options contact_tol, contact_work and contact_give. */
#ifndef NSDAE_ACCURACY_H
#define NSDAE_ACCURACY_H

typedef struct nsdae_accuracy {
  double tol;  /* contact_tol; 0: by the size of the island */
  double work; /* contact_work; 0: by the tolerance */
  double give; /* contact_give; 0: above the tolerance the method fails, in any time */
} nsdae_accuracy;

/* Of problems that are solved by pivoting or in closed form; the first of those of cones. */
double nsdae_accuracy_tol(const nsdae_accuracy *accuracy);

/* The residual up to which the best point is accepted, if it is not solved to tol; 0: none. */
double nsdae_accuracy_accept(const nsdae_accuracy *accuracy, double tol);

/* Multiplications by J for an island of this number of contacts and frictional joints, solved to
 * tol; 0: no limit but the solver's. */
double nsdae_accuracy_budget(const nsdae_accuracy *accuracy, double tol, int contacts);

/* Share of the budget of an island to reach the tolerance; all of it is to reach accept. 500 sweeps
 * of heaps leave 1e-4 to 2e-3, of walls that begin to move up to 9e-2. */
#define NSDAE_SHARE_TO_TOL 0.1

/* The tolerance of an island of cones, and multiplications by J to reach it (0: as above). */
typedef struct nsdae_aim {
  double tol, budget;
} nsdae_aim;

/* That which follows a tolerance that was not reached; after 0 the first. Its tol is 0 if there is
 * no other. */
nsdae_aim nsdae_accuracy_aim(const nsdae_accuracy *accuracy, int contacts, double after);

#endif
