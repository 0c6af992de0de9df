#include "ode.h"

#include <stdlib.h>
#include <string.h>

#include <cvode/cvode.h>
#include <nvector/nvector_serial.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>

#include "context.h"

struct nsdae_ode {
  nsdae_ode_problem problem;
  SUNContext context;
  void *cvode;
  N_Vector y;
  SUNMatrix matrix;
  SUNLinearSolver solver;
  int failed; /* code of a callback that gave up */
};

static int rate(sunrealtype t, N_Vector y, N_Vector ydot, void *user)
{
  nsdae_ode *ode = user;
  int code =
      ode->problem.rate(t, N_VGetArrayPointer(y), N_VGetArrayPointer(ydot), ode->problem.user);
  if (code < 0) ode->failed = code;
  return code;
}

static int root(sunrealtype t, N_Vector y, sunrealtype *g, void *user)
{
  nsdae_ode *ode = user;
  int code = ode->problem.root(t, N_VGetArrayPointer(y), g, ode->problem.user);
  if (code != 0) ode->failed = code;
  return code;
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
  ode->y = N_VNew_Serial(n, ode->context);
  if (!ode->y) return NSDAE_E_MEMORY;
  N_VConst(0, ode->y);
  ode->matrix = SUNDenseMatrix(n, n, ode->context);
  if (!ode->matrix) return NSDAE_E_MEMORY;
  ode->solver = SUNLinSol_Dense(ode->y, ode->matrix, ode->context);
  ode->cvode = CVodeCreate(CV_BDF, ode->context);
  return ode->solver && ode->cvode ? NSDAE_OK : NSDAE_E_MEMORY;
}

static int set_up(nsdae_ode *ode, double rtol, double atol)
{
  void *cvode = ode->cvode;
  silence(cvode);
  int bad = CVodeInit(cvode, rate, 0, ode->y);
  if (!bad) bad = CVodeSStolerances(cvode, rtol, atol);
  if (!bad) bad = CVodeSetUserData(cvode, ode);
  if (!bad) bad = CVodeSetLinearSolver(cvode, ode->solver, ode->matrix);
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
  int status = make_objects(made);
  if (status == NSDAE_OK) status = set_up(made, rtol, atol);
  if (status < 0)
    nsdae_ode_destroy(&made);
  else
    *ode = made;
  return status;
}

void nsdae_ode_destroy(nsdae_ode **ode)
{
  nsdae_ode *old = ode ? *ode : NULL;
  if (!old) return;
  if (old->cvode) CVodeFree(&old->cvode);
  if (old->solver) SUNLinSolFree(old->solver);
  if (old->matrix) SUNMatDestroy(old->matrix);
  if (old->y) N_VDestroy(old->y);
  if (old->context) SUNContext_Free(&old->context);
  free(old);
  *ode = NULL;
}

int nsdae_ode_start(nsdae_ode *ode, double t, const double *y)
{
  memcpy(N_VGetArrayPointer(ode->y), y, (size_t)ode->problem.n * sizeof *y);
  return CVodeReInit(ode->cvode, t, ode->y) == 0 ? NSDAE_OK : NSDAE_E_CONVERGENCE;
}

int nsdae_ode_advance(nsdae_ode *ode, double t_end, double *t, double *y, int *what, int *found,
                      int *code)
{
  ode->failed = 0;
  CVodeSetStopTime(ode->cvode, t_end);
  *code = CVode(ode->cvode, t_end, ode->y, t, CV_ONE_STEP);
  memcpy(y, N_VGetArrayPointer(ode->y), (size_t)ode->problem.n * sizeof *y);
  if (*code < 0) return ode->failed ? NSDAE_E_CALLBACK : NSDAE_E_CONVERGENCE;
  *what = *code == CV_ROOT_RETURN    ? NSDAE_ODE_ROOT
          : *code == CV_TSTOP_RETURN ? NSDAE_ODE_END
                                     : NSDAE_ODE_STEP;
  if (*what == NSDAE_ODE_ROOT) CVodeGetRootInfo(ode->cvode, found);
  return NSDAE_OK;
}

long nsdae_ode_rates(const nsdae_ode *ode)
{
  long own = 0, for_jacobian = 0;
  CVodeGetNumRhsEvals(ode->cvode, &own);
  CVodeGetNumLinRhsEvals(ode->cvode, &for_jacobian);
  return own + for_jacobian;
}
