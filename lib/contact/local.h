/* A small island in dense arrays: its blocks and rows are gathered, its contacts stay where they
 * are, and are solved by what solves a small system as a whole (kkt.h, contacts.h), with its
 * proofs. */
#ifndef NSDAE_LOCAL_H
#define NSDAE_LOCAL_H

#include "closed.h"
#include "contacts.h"
#include "graph.h"
#include "misfit.h"

enum { NSDAE_LOCAL_V = 48, NSDAE_LOCAL_M = 36, NSDAE_LOCAL_ROWS = 48 };

/* Velocities of a resting island that are none, in parts of the largest one of a contact without
 * impulses, where fewer digits than that are asked for. */
#define NSDAE_STILL 1e-9

typedef struct nsdae_local {
  nsdae_kkt kkt; /* of the island at hand, one block */
  nsdae_rows J;  /* its rows of Phi_q */
  nsdae_contacts contacts;
  const double *M;        /* of one block that of the whole, else the one that follows */
  double *gathered;       /* NSDAE_LOCAL_V^2 */
  double *r, *v, *size;   /* NSDAE_LOCAL_V */
  double *free, *column;  /* the same: M^-1 r less v; M^-1 W of a column */
  double *lambda, *asked; /* NSDAE_LOCAL_M; asked: -Phi_t */
  int *place;             /* of a block of the system: where it begins in the island at hand */
  int ends[2];            /* the island is one block, from 0 */
  size_t squares[2];      /* likewise, of M */
  nsdae_blocks blocks;
} nsdae_local;

/* What an island is gathered from and scattered to. */
typedef struct nsdae_whole {
  const nsdae_system *system;
  const nsdae_graph *islands;
  const nsdae_terms *terms;      /* rows of Phi_q and of the closed contacts */
  const nsdae_coefficients *law; /* of the closed contacts */
  const double *M, *r;           /* by blocks; nv */
  nsdae_closed *closed;
  nsdae_impulses *results;
  double *v, *size, *lambda;      /* nv, nv, m */
  int with_contacts;              /* 0: as if none were closed */
  struct nsdae_cone_island *kept; /* what is kept of the problem of an island of pass 1 */
  int kept_island;
} nsdae_whole;

void nsdae_local_prepare(nsdae_local *local, const nsdae_system *system, nsdae_error *error,
                         const nsdae_lcp_options *options, double rank_tol);
void nsdae_local_layout(nsdae_local *local, nsdae_arena *arena);

/* Whether an island fits. */
int nsdae_local_fits(const nsdae_whole *whole, int island);

/* v and lambda of the island's blocks and rows from r and lambda = -Phi_t, without contacts or
 * with them and their impulses, modes and velocities after; misfit: of the contacts and their rows,
 * if there are contacts. NSDAE_OK; NSDAE_E_MASS, and NSDAE_E_RANK unless least_norm allows it, of
 * kkt without a record; NSDAE_E_LCP, NSDAE_E_INFEASIBLE, NSDAE_E_NONFINITE with it. */
int nsdae_local_solve(nsdae_local *local, const nsdae_whole *whole, int island, int least_norm,
                      nsdae_misfit *misfit);

#endif
