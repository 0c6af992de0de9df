/* The solver as it is called: arguments, memory, islands, certificate, names. */
#include <float.h>
#include <math.h>
#include <nsdae/friction.h>
#include <stdlib.h>
#include <string.h>

#include "friction_solver.h"
#include "stages.h"
#include "static_condensation.h"
#include "vector.h"

/* The certificate is of the data as given, an island's residual of the scaled data. They differ by
 * the rounding of impulses up to 1e6 times the least that moves a contact. */
static const double ROUNDING = 1e-9;

/* With the bilateral rows eliminated: the first, and two with the tolerance that it asks for. */
enum { ATTEMPTS = 3 };

struct nsdae_friction_solver {
  nsdae_arena global_memory, island_memory;
  nsdae_fc_global global;
  nsdae_fc_system system;
  nsdae_fc_farkas farkas;
  nsdae_fc_run run;
  nsdae_fc_condensed condensed;
  nsdae_friction_solver *contacts; /* of it; NULL: not needed so far */
  int double_double;               /* the caller takes r + low */
  nsdae_thread_pool *pool;
};

void nsdae_friction_options_default(nsdae_friction_options *options)
{
  if (options) *options = (nsdae_friction_options){.tol = 1e-10, .stages = NSDAE_FRICTION_ALL};
}

const char *nsdae_friction_stage_name(int stage)
{
  switch (stage) {
  case NSDAE_FRICTION_NONE:
    return "none";
#define NAME(name, value, word, text) \
  case value:                         \
    return word;
    NSDAE_FRICTION_STAGE_LIST(NAME)
#undef NAME
  default:
    return "unknown";
  }
}

int nsdae_friction_create(nsdae_friction_solver **solver)
{
  if (!solver) return NSDAE_E_ARGUMENT;
  *solver = calloc(1, sizeof **solver);
  return *solver ? NSDAE_OK : NSDAE_E_MEMORY;
}

void nsdae_friction_destroy(nsdae_friction_solver **solver)
{
  if (!solver || !*solver) return;
  nsdae_arena_release(&(*solver)->global_memory);
  nsdae_arena_release(&(*solver)->island_memory);
  nsdae_fc_system_release(&(*solver)->system);
  nsdae_arena_release(&(*solver)->farkas.memory);
  nsdae_fc_condensed_release(&(*solver)->condensed);
  nsdae_friction_destroy(&(*solver)->contacts);
  free(*solver);
  *solver = NULL;
}

void nsdae_fc_set_pool(nsdae_friction_solver *solver, nsdae_thread_pool *pool)
{
  solver->pool = pool;
}

/* ---- memory and data */

/* The problem checked and without its masses. */
static int prepare(nsdae_friction_solver *s, const nsdae_friction_problem *p, nsdae_error *error)
{
  int status = nsdae_fc_problem_check(p, error);
  if (status != NSDAE_OK) return status;
  s->global = (nsdae_fc_global){.view.p = p, .pool = s->pool};
  if (nsdae_arena_fit(&s->global_memory, nsdae_fc_global_layout, &s->global) != NSDAE_OK)
    return nsdae_fc_refuse(error, NSDAE_E_MEMORY, "problem", -1, "out of memory");
  return nsdae_fc_global_fill(&s->global, error);
}

static int lay_out_island(nsdae_friction_solver *s, int island)
{
  s->run = (nsdae_fc_run){.island = {.fc = {.global = &s->global, .label = island},
                                     .system = &s->system,
                                     .farkas = &s->farkas,
                                     .proof = s->global.r},
                          .islands = s->global.islands.count};
  return nsdae_arena_fit(&s->island_memory, nsdae_fc_run_layout, &s->run);
}

int nsdae_fc_reserve(nsdae_friction_solver *s, const nsdae_friction_problem *largest)
{
  int status = prepare(s, largest, NULL);
  for (int island = 0; island < s->global.islands.count && status == NSDAE_OK; island++) {
    status = lay_out_island(s, island);
    if (status != NSDAE_OK) return status;
    nsdae_fc_fill(&s->run.island.fc, s->global.q);
    status = nsdae_fc_system_analyse(&s->system, &s->run.island.fc);
  }
  return status;
}

double nsdae_fc_speed(const nsdae_friction_solver *s)
{
  return nsdae_largest(s->global.view.m, s->global.q);
}

/* ---- islands */

/* The info is the largest stage of the islands, the sum of their work. Items that nothing moves get
 * r = 0, all others the answer of their island, in whole.r; or that is the proof that an island has
 * none. */
static int solve_islands(nsdae_friction_solver *s, const nsdae_friction_options *options,
                         const double *guess, nsdae_friction_info *info)
{
  nsdae_fc_global *w = &s->global;
  nsdae_fc_run *run = &s->run;
  int status = NSDAE_OK;
  memset(w->r, 0, (size_t)w->view.m * sizeof *w->r);
  memset(w->r_low, 0, (size_t)w->view.m * sizeof *w->r_low);
  for (int island = 0; island < w->islands.count && status == NSDAE_OK; island++) {
    if (w->islands.count > 1) lay_out_island(s, island); /* one alone is laid out */
    run->options = options;
    run->budget.tol = options->tol - fmin(0.2 * options->tol, ROUNDING);
    run->budget.double_double = s->double_double;
    run->island.fc.exact = fmax(1e-15, 1e-3 * options->tol);
    nsdae_fc_fill(&run->island.fc, guess);
    status = nsdae_fc_run_stages(run);
    if (status == NSDAE_E_MEMORY) return status;
    info->islands++;
    info->sweeps += run->info.sweeps;
    info->iterations += run->info.iterations;
    info->factorisations += run->info.factorisations;
    if (run->info.stage > info->stage) info->stage = run->info.stage;
    if (run->info.outcome == NSDAE_OUTCOME_INFEASIBLE) return NSDAE_E_INFEASIBLE;
    nsdae_fc_scatter(&run->island.fc, run->iterate.r, w->r);
    nsdae_fc_scatter(&run->island.fc, run->iterate.low, w->r_low);
  }
  return status;
}

/* Hands over the proof in whole.r. */
static int refute(const nsdae_fc_global *w, double *r, double *u, nsdae_friction_info *info)
{
  info->outcome = NSDAE_OUTCOME_INFEASIBLE;
  info->proof = NSDAE_PROOF_FARKAS;
  info->stage = NSDAE_FRICTION_FARKAS;
  memset(r, 0, (size_t)w->view.m * sizeof *r);
  info->residual = nsdae_fc_global_residual(w, r, NULL, u);
  memcpy(r, w->r, (size_t)w->view.m * sizeof *r);
  return NSDAE_E_INFEASIBLE;
}

/* ---- solution and certificate */

/* The certificate, of r as it is handed over (and low, unless that is NULL). */
static int certify(const nsdae_fc_global *w, double tol, double *r, double *low, double *u,
                   nsdae_friction_info *info)
{
  if (w->view.m > 0) memcpy(r, w->r, (size_t)w->view.m * sizeof *r);
  if (w->view.m > 0 && low) memcpy(low, w->r_low, (size_t)w->view.m * sizeof *low);
  info->residual = nsdae_fc_global_residual(w, r, low, u);
  if (info->residual != info->residual) info->residual = INFINITY;
  info->outcome = info->residual <= tol ? NSDAE_OUTCOME_SOLVED : NSDAE_OUTCOME_UNSOLVED;
  if (info->outcome == NSDAE_OUTCOME_SOLVED && info->stage == NSDAE_FRICTION_NONE)
    info->stage = NSDAE_FRICTION_TRIVIAL;
  return info->outcome == NSDAE_OUTCOME_SOLVED ? NSDAE_OK : NSDAE_E_LCP;
}

/* ---- bilateral rows */

/* The contacts alone, if their problem is small, to a tolerance that gives that of the whole: the
 * two residuals differ by the diagonals of W and the largest velocities. options.refine: if more
 * than the rounding of sums of m terms is left, once more from the velocities of the whole. Returns
 * a status, 1: not solved; r is then the better guess. */
static int solve_condensed(nsdae_friction_solver *s, const nsdae_friction_options *options,
                           double *r, double *u, nsdae_friction_info *info)
{
  nsdae_friction_options own = *options;
  nsdae_friction_info part;
  const double rounding = s->global.view.m * DBL_EPSILON;
  int done = nsdae_fc_condense(&s->condensed, &s->global);
  if (done <= 0) return done < 0 ? done : 1;
  if (!s->contacts && nsdae_friction_create(&s->contacts) < 0) return NSDAE_E_MEMORY;
  for (int attempt = 0; attempt < ATTEMPTS; attempt++) {
    int status = nsdae_friction_solver_solve(s->contacts, &s->condensed.problem, &own, r, u, &part);
    info->islands = part.islands;
    info->sweeps += part.sweeps;
    info->iterations += part.iterations;
    info->factorisations += part.factorisations;
    if (part.stage > info->stage) info->stage = part.stage;
    if (status == NSDAE_E_INTERRUPTED || status == NSDAE_E_MEMORY) return status;
    if (status != NSDAE_OK) return 1;
    nsdae_fc_condensed_multipliers(&s->condensed, r);
    memcpy(s->global.r, r, (size_t)s->global.view.m * sizeof *r);
    status = certify(&s->global, options->tol, r, NULL, u, info);
    if (status == NSDAE_OK && (options->refine == 0 || attempt > 0 || info->residual <= rounding))
      return status;
    if (status != NSDAE_OK) own.tol *= fmin(0.5, 0.5 * options->tol / info->residual);
    if (!(own.tol > 1e-14)) return 1;
    nsdae_fc_condensed_correct(&s->condensed, r, u);
  }
  return 1;
}

/* All of a solution; low NULL: in one part. */
static int solve_problem(nsdae_friction_solver *s, const nsdae_friction_problem *problem,
                         const nsdae_friction_options *options, double *r, double *low, double *u,
                         nsdae_friction_info *info)
{
  nsdae_friction_options defaults;
  nsdae_friction_info own;
  nsdae_friction_options_default(&defaults);
  if (!options) options = &defaults;
  if (!info) info = &own;
  *info = (nsdae_friction_info){.residual = INFINITY};
  if (!s || !(options->tol > 0 && options->tol <= 1) || options->stages < 0 ||
      options->stages > NSDAE_FRICTION_ALL || options->max_sweeps < 0 ||
      options->max_iterations < 0 || options->refine < 0 ||
      !(options->budget >= 0 && options->budget < INFINITY))
    return NSDAE_E_ARGUMENT;
  int status = prepare(s, problem, NULL);
  if (status != NSDAE_OK) return status;
  if (s->global.view.m > 0 && (!r || !u)) return NSDAE_E_ARGUMENT;
  s->double_double = low != NULL;
  /* Memory for each island, before anything of the caller's is changed. */
  for (int island = 0; island < s->global.islands.count; island++)
    if (lay_out_island(s, island) != NSDAE_OK) return NSDAE_E_MEMORY;
  int blocked = nsdae_fc_global_blocked(&s->global);
  if (blocked >= 0) {
    /* An item that nothing moves: its own direction, against its velocity. */
    int row = s->global.view.row[blocked];
    memset(s->global.r, 0, (size_t)s->global.view.m * sizeof *r);
    s->global.r[row] = s->global.q[row] < 0 ? 1 : -1;
    return refute(&s->global, r, u, info);
  }
  if (!low) {
    status = solve_condensed(s, options, r, u, info);
    if (status <= 0) return status;
  }
  status = solve_islands(s, options, r, info);
  if (status == NSDAE_E_INFEASIBLE) return refute(&s->global, r, u, info);
  if (status != NSDAE_OK && status != NSDAE_E_INTERRUPTED) return status;
  int certified = certify(&s->global, options->tol, r, low, u, info);
  return status == NSDAE_E_INTERRUPTED ? status : certified;
}

/* ---- interface */

int nsdae_friction_solver_solve(nsdae_friction_solver *solver,
                                const nsdae_friction_problem *problem,
                                const nsdae_friction_options *options, double *r, double *u,
                                nsdae_friction_info *info)
{
  return solve_problem(solver, problem, options, r, NULL, u, info);
}

/* With a solver of its own. */
static int solve_once(const nsdae_friction_problem *problem, const nsdae_friction_options *options,
                      double *r, double *low, double *u, nsdae_friction_info *info)
{
  nsdae_friction_solver *solver;
  if (info) *info = (nsdae_friction_info){.residual = INFINITY};
  int status = nsdae_friction_create(&solver);
  if (status != NSDAE_OK) return status;
  status = solve_problem(solver, problem, options, r, low, u, info);
  nsdae_friction_destroy(&solver);
  return status;
}

int nsdae_friction_solve(const nsdae_friction_problem *problem,
                         const nsdae_friction_options *options, double *r, double *u,
                         nsdae_friction_info *info)
{
  return solve_once(problem, options, r, NULL, u, info);
}

int nsdae_friction_solve_twice(const nsdae_friction_problem *problem,
                               const nsdae_friction_options *options, double *r, double *low,
                               double *u, nsdae_friction_info *info)
{
  return solve_once(problem, options, r, low, u, info);
}

int nsdae_friction_check(const nsdae_friction_problem *problem, nsdae_error *error)
{
  nsdae_friction_solver s = {0};
  int status = prepare(&s, problem, error);
  nsdae_arena_release(&s.global_memory);
  return status;
}

int nsdae_friction_residual(const nsdae_friction_problem *problem, const double *r, double *u,
                            double *residual)
{
  return nsdae_friction_residual_twice(problem, r, NULL, u, residual);
}

int nsdae_friction_residual_twice(const nsdae_friction_problem *problem, const double *r,
                                  const double *low, double *u, double *residual)
{
  nsdae_friction_solver s = {0};
  double *own = NULL;
  if (!residual) return NSDAE_E_ARGUMENT;
  int status = prepare(&s, problem, NULL);
  if (status == NSDAE_OK && s.global.view.m > 0 && !r) status = NSDAE_E_ARGUMENT;
  if (status == NSDAE_OK && !u) {
    own = malloc(((size_t)s.global.view.m + 1) * sizeof *own);
    status = own ? NSDAE_OK : NSDAE_E_MEMORY;
  }
  if (status == NSDAE_OK) *residual = nsdae_fc_global_residual(&s.global, r, low, u ? u : own);
  free(own);
  nsdae_arena_release(&s.global_memory);
  return status;
}
