/* The contact problem of one step or instant, with the frictional joints (see slides.h) as further
 * rows.
 *
 * With the columns W of the closed contacts, P the projector of [M Phi_q^T; Phi_q 0] and v_free
 * the velocity that the system would have without contacts,
 *
 *     [U; D] = solve [M Phi_q^T; Phi_q 0] on [W; 0]      U = P W
 *     G = W^T U                                           Delassus matrix
 *     xi = G Lambda + W^T v_free + w(+) + e v(-)          v(-): the contacts' velocity before
 *     y = A x + b,  A = E_P^T G E_Q + N                   see law.h; Eq. (33)
 *     v(+) = v_free + U Lambda,  lambda = lambda_free + D Lambda      Eqs. (31, 32)
 *
 * Where a closed contact has the cone for its law, cones.h finds Lambda in place of y = A x + b. */
#ifndef NSDAE_CONTACTS_H
#define NSDAE_CONTACTS_H

#include <nsdae/lcp.h>

#include "accuracy.h"
#include "arena.h"
#include "cones.h"
#include "impulses.h"
#include "law.h"
#include "terms.h"

/* xi = G Lambda + offset, by columns. */
typedef struct nsdae_delassus {
  double *W, *U, *D;    /* nv, nv, m times columns */
  double *G;            /* columns x columns */
  double *offset;       /* columns: W^T v_free + w(+) + e v(-) */
  double *impulse;      /* columns: Lambda */
  double *impulse_size; /* columns: the sum of the absolute terms of Lambda */
} nsdae_delassus;

/* The complementarity problem, and what its solver works with. */
typedef struct nsdae_contact_lcp {
  nsdae_lcp_options options;
  nsdae_lcp_info info;     /* of the last problem */
  nsdae_accuracy accuracy; /* of islands; options.tol is that of complementarity problems */
  double accept;           /* its best point is accepted up to this residual; 0: if it is solved */
  int accepted;            /* it was, above the tolerance */
  double *A, *b, *x, *y;   /* rows x rows, rows */
  int *basis;              /* rows */
  double edge[2 * NSDAE_POLYGON_MAX];
  double *work, *other; /* lwork; 4 rows: of another problem, see acceleration.c */
  int *iwork, lwork, liwork;
} nsdae_contact_lcp;

/* What the frictional joints make of the unknowns: see slides.h. */
typedef struct nsdae_slide_map {
  double *Z, *GZ; /* columns x rows: Lambda = Z x + z0, G Z */
  double *z0;     /* columns */
  double *offset; /* columns: with G z0 */
  double *K, *k0; /* slides x rows, slides: l- = K x + k0 */
  double *Q;      /* slides x slides */
  double *D_S;    /* slides x columns */
  int *pivot;     /* slides */
} nsdae_slide_map;

/* scale xi_T + compliance (Lambda_T / scale) + shift in place of xi_T, and Lambda_T / scale for the
 * impulse of the column: of a position motor, see slides.h. Of others the scale is 1. */
typedef struct nsdae_joint_row {
  double compliance, shift, scale;
} nsdae_joint_row;

/* Frictional joints: their columns and rows come after those of the contacts. */
typedef struct nsdae_contact_slides {
  int count, *number;            /* of them; their numbers */
  int *constraint;               /* count: the row of Phi_q of each in the part */
  int *place;                    /* count: of its basis in the warm start */
  int *row;                      /* count: first row of each, see nsdae_slides_rows */
  const double *bound;           /* f: largest impulse (or force) without a load; NULL: none */
  const nsdae_joint_row *beside; /* f; NULL: none */
  double *limit;                 /* count: that of each as the problem has it */
  double terms;                  /* |w| + |W^T v_free|, the largest of a slide */
  double fastest;                /* the largest velocity of a column without impulses */
  const int *sense; /* f: +1 or -1 where a slide is known to slide that way; NULL: none */
} nsdae_contact_slides;

/* The warm start of a problem: the caller's arrays. */
typedef struct nsdae_contact_warm {
  int *basis, *slide_basis; /* k x rows_most, 3 slides.count: the last basis of each */
} nsdae_contact_warm;

/* The system of the problem, or an island of it. */
typedef struct nsdae_contact_part {
  const nsdae_coefficients *coefficient; /* of the contacts, by number */
  const int *place;                      /* of a block: where its velocities begin in v */
  const long *id;                        /* of the contacts of a list */
  const nsdae_rows *J; /* Phi_q of an island, over the blocks of kkt; NULL: the terms' */
  int m;               /* its rows */
  double *reaction;    /* nv */
} nsdae_contact_part;

typedef struct nsdae_contacts {
  const nsdae_system *system;
  nsdae_error *error;
  nsdae_contact_part part;
  const nsdae_law *given;    /* laws by number of the contact; NULL: those of its coefficients */
  int edges, rows_most;      /* of a polygon; of any contact */
  long rows_in_all;          /* of all of them, and of the frictional joints */
  int active_count, *active; /* the closed contacts */
  nsdae_law *law;            /* per closed contact */
  int columns, rows; /* of the problem, over the closed contacts and the frictional joints */
  int *first_column, *first_row; /* per closed contact, with one past the last */
  nsdae_contact_slides slides;
  nsdae_delassus delassus;
  nsdae_slide_map map;
  nsdae_contact_lcp lcp;
  nsdae_cones cones;
  nsdae_impulses *results; /* where those of the problem go */
  nsdae_contact_warm warm;
} nsdae_contacts;

/* Takes the arrays for these sizes; system, error and rows_in_all are set before. */
void nsdae_contacts_layout(nsdae_contacts *contacts, const nsdae_dims *most, nsdae_arena *arena);

/* The coefficients of the whole system, the rows that they lead to with polygons of this number of
 * edges, and the frictional joints. */
void nsdae_contacts_laws(nsdae_contacts *contacts, int polygon_edges);

/* Settings of a problem of the system; then as above. */
void nsdae_contacts_set(nsdae_contacts *contacts, const nsdae_system *system, nsdae_error *error,
                        const nsdae_accuracy *accuracy, int polygon_edges);

/* After a solver ended with this status: NSDAE_OK in place of NSDAE_E_LCP if accept allows it. */
int nsdae_contacts_accept(nsdae_contacts *contacts, int status);

/* Number of rows that the contacts and frictional joints of a system can have together, and how
 * many a problem may have. */
long nsdae_contacts_rows(const nsdae_system *system, int polygon_edges);
int nsdae_contacts_rows_limit(void);

/* The bases that problems begin from and leave are the caller's: k rows_most + 3 slides.count
 * integers, zero where there is none yet. Cones begin from the impulses in the results. */
void nsdae_contacts_remember(nsdae_contacts *contacts, int *memory);

/* Slides take rows from first on, and are the last of them. */
void nsdae_contacts_place_slides(nsdae_contacts *contacts, int first);

/* The complementarity problem as it is assembled; status of nsdae_lcp_solve. */
int nsdae_contacts_solve_lcp(nsdae_contacts *contacts);

/* A new problem: closes the contacts [k] that are marked; the others are open. The results go to
 * the given place, which is cleared. */
void nsdae_contacts_close_marked(nsdae_contacts *contacts, const int *closed,
                                 nsdae_impulses *results);

/* The same with these contacts; the results are not cleared. */
void nsdae_contacts_close_these(nsdae_contacts *contacts, int count, const int *contact,
                                nsdae_impulses *results);

/* Stores v(-) of the closed contacts and the frictional joints: W^T v + w with the terms' W and w;
 * with impacts_only, of the contacts that are marked as impacts. */
void nsdae_contacts_before(nsdae_contacts *contacts, const nsdae_terms *terms, const double *v,
                           int impacts_only);

/* The same of these numbers, without joints, into r. */
void nsdae_contacts_approach(const nsdae_terms *terms, int count, const int *contact,
                             const double *v, int impacts_only, nsdae_impulses *r);

/* v_N(-) [k] is this instead, as where a part of it is the errors of an integration. */
void nsdae_contacts_come(nsdae_contacts *contacts, const double *before);

/* Whether contacts have polygons as they are asked for. */
static inline int nsdae_contacts_polygons(const nsdae_contacts *contacts)
{
  return contacts->system->dims.nt == 2 && contacts->edges > 0;
}

/* Whether there is anything to solve for. */
static inline int nsdae_contacts_any(const nsdae_contacts *contacts)
{
  return contacts->active_count + contacts->slides.count > 0;
}

/* Whether friction can move contact or frictional joint in this column of the problem at all. */
static inline int nsdae_contacts_powerless(const nsdae_contacts *contacts, int column)
{
  return contacts->delassus.G[(size_t)column * (size_t)(contacts->columns + 1)] == 0;
}

/* Solves for the closed contacts and the frictional joints. On entry v [nv] and lambda [m] are free
 * of contacts, on return they hold v(+) and lambda; W and w are the terms', kkt is factored; size
 * [nv] is how large the terms of v were before they were summed, on return those of v(+): what is
 * smaller by all digits is zero. NSDAE_OK; NSDAE_E_LCP, NSDAE_E_INFEASIBLE, NSDAE_E_NONFINITE with
 * the record filled and v, lambda unchanged. */
int nsdae_contacts_solve(nsdae_contacts *contacts, const nsdae_terms *terms, const nsdae_kkt *kkt,
                         double *size, double *v, double *lambda);

/* The same of momentum r [nv]: v, lambda, which comes as -Phi_t, and size without contacts first.
 */
int nsdae_contacts_step(nsdae_contacts *contacts, const nsdae_terms *terms, const nsdae_kkt *kkt,
                        const double *r, double *v, double *size, double *lambda);

/* Work that the last impulses did on the system: the sum of Lambda (v(+) + v(-)) / 2. */
double nsdae_contacts_work(const nsdae_contacts *contacts);

#endif
