/* Backward differences (BDF) of variable order and step by SUNDIALS CVODE: Hindmarsh et al., ACM
 * Trans. Math. Softw. 31 (2005) 363. */
#include "ode.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <cvode/cvode.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>

#include "context.h"
#include "pool.h"
#include "stalled_steps.h"
#include "vector.h"

struct nsdae_ode {
  nsdae_ode_problem problem;
  SUNContext context;
  nsdae_pool pool;
  void *cvode;
  N_Vector y, between; /* where it is; where it is read */
  double rtol, atol;
  int positions;              /* of y: see nsdae_ode_positions */
  double longest, way;        /* in which; that of the last evaluation of f */
  SUNMatrix matrix, jacobian; /* I - gamma J, J */
  SUNLinearSolver solver;
  long rates; /* evaluations of f */
  nsdae_progress progress;
};

static int rate(sunrealtype t, N_Vector y, N_Vector ydot, void *user)
{
  nsdae_ode *ode = user;
  double *to = N_VGetArrayPointer(ydot), most = 0;
  ode->rates++;
  int code = ode->problem.rate(t, N_VGetArrayPointer(y), to, ode->problem.user);
  for (int i = 0; i < ode->positions; i++) most = fmax(most, fabs(to[i]));
  if (code == 0) ode->way = ode->longest * most;
  return nsdae_progress_note(&ode->progress, code);
}

/* Error weights 1 / w_i. What is not controlled has a weight of nothing, and no part in the mean of
 * CVODE's norm. */
static int weigh(N_Vector y, N_Vector weights, void *user)
{
  const nsdae_ode *ode = user;
  double share = sqrt((double)ode->problem.controlled / ode->problem.n);
  double *w = N_VGetArrayPointer(weights);
  const double *at = N_VGetArrayPointer(y);
  for (int i = 0; i < ode->problem.n; i++) {
    double scale = i < ode->positions ? fmin(fabs(at[i]), ode->way) : fabs(at[i]);
    w[i] = i < ode->problem.controlled ? 1 / (share * (ode->rtol * scale + ode->atol)) : 1e-150;
  }
  return 0;
}

static int root(sunrealtype t, N_Vector y, sunrealtype *g, void *user)
{
  nsdae_ode *ode = user;
  int code = ode->problem.root(t, N_VGetArrayPointer(y), g, ode->problem.user);
  if (code != 0) ode->progress.failed = code;
  return code;
}

static int rate_near(nsdae_ode *ode, double t, N_Vector y_0, N_Vector y, N_Vector ydot)
{
  const nsdae_ode_problem *p = &ode->problem;
  if (!p->near) return rate(t, y, ydot, ode);
  ode->rates++;
  int code =
      p->near(t, N_VGetArrayPointer(y_0), N_VGetArrayPointer(y), N_VGetArrayPointer(ydot), p->user);
  return nsdae_progress_note(&ode->progress, code);
}

/* sigma_0 of differentiate */
static double least_increment(const nsdae_ode *ode, double gamma, N_Vector f, N_Vector weights)
{
  double norm = N_VWrmsNorm(f, weights);
  return norm > 0 ? 1000 * fabs(gamma) * SUN_UNIT_ROUNDOFF * ode->problem.n * norm : 1;
}

/* max |v|, where f is linear near y. What f takes of velocities together, as of a slip that is
 * their sum and hardly there, is known to U max |v| however small one of them is: a difference over
 * less than that is noise. */
static double largest_velocity(const nsdae_ode *ode, N_Vector y)
{
  int positions = ode->positions, velocities = ode->problem.controlled - positions;
  if (!ode->problem.near || positions == 0) return 0;
  return nsdae_largest(velocities, N_VGetArrayPointer(y) + positions);
}

/* J = df/dy by differences, with the increments of CVODE's own (user guide of CVODE, "Mathematical
 * considerations", dense Jacobian): max(sqrt(U) |y_j|, sigma_0 / W_j), W the error weights,
 * sigma_0 = 1000 |h| U n ||f||_WRMS, but with gamma = h / l_1 (l_1 from 1 to 2.3) for h: what CVODE
 * gives for it before a first step is that of the integration before. Velocities move by
 * sqrt(U) max |v| at least. */
static int differentiate(nsdae_ode *ode, double t, double gamma, N_Vector y, N_Vector f,
                         N_Vector moved, N_Vector f_there, N_Vector weights)
{
  CVodeGetErrWeights(ode->cvode, weights);
  N_VScale(1, y, moved);
  double least = least_increment(ode, gamma, f, weights), root_of_u = sqrt(SUN_UNIT_ROUNDOFF);
  double fastest = largest_velocity(ode, y);
  double *x = N_VGetArrayPointer(moved), *W = N_VGetArrayPointer(weights);
  const double *f_0 = N_VGetArrayPointer(f), *f_1 = N_VGetArrayPointer(f_there);
  SUNMatZero(ode->jacobian);
  for (int j = 0; j < ode->problem.controlled; j++) {
    double here = x[j], scale = j < ode->positions ? fabs(here) : fmax(fabs(here), fastest);
    double increment = fmax(root_of_u * scale, least / W[j]);
    double *column = SUNDenseMatrix_Column(ode->jacobian, j), inverse = 1 / increment;
    x[j] = here + increment;
    int code = rate_near(ode, t, y, moved, f_there);
    if (code != 0) return code;
    for (int i = 0; i < ode->problem.n; i++) column[i] = inverse * (f_1[i] - f_0[i]);
    x[j] = here;
  }
  return 0;
}

/* A = I - gamma J, J the one of before where CVODE takes it for good enough (jok). Left to itself,
 * CVODE allocates J at the first step and a vector for every new one. */
static int linear_system(sunrealtype t, N_Vector y, N_Vector f, SUNMatrix A, sunbooleantype jok,
                         sunbooleantype *jcur, sunrealtype gamma, void *user, N_Vector tmp1,
                         N_Vector tmp2, N_Vector tmp3)
{
  nsdae_ode *ode = user;
  *jcur = !jok;
  int code = jok ? 0 : differentiate(ode, t, gamma, y, f, tmp1, tmp2, tmp3);
  if (code != 0) return code;
  return SUNMatCopy(ode->jacobian, A) == 0 && SUNMatScaleAddI(-gamma, A) == 0 ? 0 : -1;
}

static void silence(void *cvode)
{
#if SUNDIALS_VERSION_MAJOR < 7
  CVodeSetErrFile(cvode, NULL);
#else
  (void)cvode; /* the context is silent */
#endif
}

static int make_objects(nsdae_ode *ode)
{
  int n = ode->problem.n;
  if (nsdae_make_context(&ode->context) != 0) return NSDAE_E_MEMORY;
  ode->y = nsdae_pool_vector(&ode->pool, n, ode->context);
  if (!ode->y) return NSDAE_E_MEMORY;
  ode->between = nsdae_pool_vector(&ode->pool, n, ode->context);
  if (!ode->between || nsdae_pool_fill(&ode->pool, ode->y) != 0) return NSDAE_E_MEMORY;
  ode->matrix = SUNDenseMatrix(n, n, ode->context);
  ode->jacobian = SUNDenseMatrix(n, n, ode->context);
  if (!ode->matrix || !ode->jacobian) return NSDAE_E_MEMORY;
  ode->solver = SUNLinSol_Dense(ode->y, ode->matrix, ode->context);
  ode->cvode = CVodeCreate(CV_BDF, ode->context);
  return ode->solver && ode->cvode ? NSDAE_OK : NSDAE_E_MEMORY;
}

static int set_up(nsdae_ode *ode)
{
  void *cvode = ode->cvode;
  silence(cvode);
  int bad = CVodeInit(cvode, rate, 0, ode->y);
  if (!bad) bad = CVodeWFtolerances(cvode, weigh);
  if (!bad) bad = CVodeSetUserData(cvode, ode);
  if (!bad) bad = CVodeSetLinearSolver(cvode, ode->solver, ode->matrix);
  if (!bad) bad = CVodeSetLinSysFn(cvode, linear_system);
  if (!bad) bad = CVodeSetMaxNumSteps(cvode, -1);
  if (!bad && ode->problem.roots > 0) bad = CVodeRootInit(cvode, ode->problem.roots, root);
  if (!bad && ode->problem.roots > 0) bad = CVodeSetNoInactiveRootWarn(cvode);
  return bad ? NSDAE_E_MEMORY : NSDAE_OK;
}

int nsdae_ode_create(const nsdae_ode_problem *problem, double rtol, double atol, nsdae_ode **ode)
{
  *ode = NULL;
  nsdae_ode *made = calloc(1, sizeof *made);
  if (!made) return NSDAE_E_MEMORY;
  made->problem = *problem;
  made->rtol = rtol;
  made->atol = atol;
  if (problem->controlled == 0) made->problem.controlled = problem->n;
  int status = make_objects(made);
  if (status == NSDAE_OK) status = set_up(made);
  if (status < 0)
    nsdae_ode_destroy(&made);
  else
    *ode = made;
  return status;
}

void nsdae_ode_tolerances(nsdae_ode *ode, double rtol, double atol, double step_max)
{
  ode->rtol = rtol;
  ode->atol = atol;
  CVodeSetMaxStep(ode->cvode, step_max);
}

void nsdae_ode_positions(nsdae_ode *ode, int positions, double longest)
{
  ode->positions = positions;
  ode->longest = longest;
}

void nsdae_ode_destroy(nsdae_ode **ode)
{
  nsdae_ode *old = ode ? *ode : NULL;
  if (!old) return;
  if (old->cvode) CVodeFree(&old->cvode);
  if (old->solver) SUNLinSolFree(old->solver);
  if (old->matrix) SUNMatDestroy(old->matrix);
  if (old->jacobian) SUNMatDestroy(old->jacobian);
  if (old->between) N_VDestroy(old->between);
  if (old->y) N_VDestroy(old->y);
  nsdae_pool_close(&old->pool);
  if (old->context) SUNContext_Free(&old->context);
  free(old);
  *ode = NULL;
}

int nsdae_ode_start(nsdae_ode *ode, double t, const double *y)
{
  ode->progress = (nsdae_progress){0};
  memcpy(N_VGetArrayPointer(ode->y), y, (size_t)ode->problem.n * sizeof *y);
  if (ode->positions > 0 && rate(t, ode->y, ode->between, ode) != 0) return NSDAE_E_CALLBACK;
  return CVodeReInit(ode->cvode, t, ode->y) == 0 ? NSDAE_OK : NSDAE_E_CONVERGENCE;
}

int nsdae_ode_advance(nsdae_ode *ode, double t_end, double *t, double *y, int *what, int *found,
                      int *code)
{
  double from = *t;
  nsdae_progress_begin(&ode->progress);
  CVodeSetStopTime(ode->cvode, t_end);
  *code = CVode(ode->cvode, t_end, ode->y, t, CV_ONE_STEP);
  memcpy(y, N_VGetArrayPointer(ode->y), (size_t)ode->problem.n * sizeof *y);
  if (nsdae_progress_lost(&ode->progress, *t > from || *code == CV_ROOT_RETURN) && *code >= 0)
    *code = CV_CONV_FAILURE;
  if (*code < 0) return ode->progress.failed ? NSDAE_E_CALLBACK : NSDAE_E_CONVERGENCE;
  *what = *code == CV_ROOT_RETURN    ? NSDAE_ODE_ROOT
          : *code == CV_TSTOP_RETURN ? NSDAE_ODE_END
                                     : NSDAE_ODE_STEP;
  if (*what == NSDAE_ODE_ROOT) CVodeGetRootInfo(ode->cvode, found);
  return NSDAE_OK;
}

int nsdae_ode_read(nsdae_ode *ode, double t, double *y)
{
  if (CVodeGetDky(ode->cvode, t, 0, ode->between) != 0) return NSDAE_E_CONVERGENCE;
  memcpy(y, N_VGetArrayPointer(ode->between), (size_t)ode->problem.n * sizeof *y);
  return NSDAE_OK;
}

long nsdae_ode_rates(const nsdae_ode *ode)
{
  return ode->rates;
}
