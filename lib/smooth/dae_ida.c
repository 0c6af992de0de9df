#include "dae.h"

#include <stdlib.h>
#include <string.h>

#include <ida/ida.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>

#include "context.h"
#include "pool.h"
#include "progress.h"
#include "sparse_lu.h"

struct nsdae_dae {
  nsdae_dae_problem problem;
  SUNContext context;
  nsdae_pool pool;
  void *ida;
  N_Vector y, yp, order;
  SUNMatrix matrix;
  SUNLinearSolver solver;
  int *falling;       /* roots: all -1 */
  nsdae_sparse_lu lu; /* where the problem is sparse */
  nsdae_arena arena;
  double after; /* where the next step goes */
  nsdae_progress progress;
};

static int residual(sunrealtype t, N_Vector y, N_Vector yp, N_Vector r, void *user)
{
  nsdae_dae *dae = user;
  return nsdae_progress_note(&dae->progress,
                             dae->problem.residual(t, N_VGetArrayPointer(y), N_VGetArrayPointer(yp),
                                                   N_VGetArrayPointer(r), dae->problem.user));
}

static int root(sunrealtype t, N_Vector y, N_Vector yp, sunrealtype *g, void *user)
{
  nsdae_dae *dae = user;
  int code =
      dae->problem.root(t, N_VGetArrayPointer(y), N_VGetArrayPointer(yp), g, dae->problem.user);
  if (code != 0) dae->progress.failed = code;
  return code;
}

static int jacobian(sunrealtype t, sunrealtype c, N_Vector y, N_Vector yp, N_Vector r, SUNMatrix J,
                    void *user, N_Vector tmp1, N_Vector tmp2, N_Vector tmp3)
{
  nsdae_dae *dae = user;
  (void)tmp1;
  (void)tmp2;
  (void)tmp3;
  return nsdae_progress_note(&dae->progress,
                             dae->problem.jacobian(t, c, N_VGetArrayPointer(y),
                                                   N_VGetArrayPointer(yp), N_VGetArrayPointer(r),
                                                   SUNDenseMatrix_Data(J), dae->problem.user));
}

/* A linear solver of SUNDIALS on our sparse factors: its own, KLU, allocates in a run. */

static SUNLinearSolver_Type sparse_type(SUNLinearSolver solver)
{
  (void)solver;
  return SUNLINEARSOLVER_DIRECT;
}

static int sparse_initialize(SUNLinearSolver solver)
{
  (void)solver;
  return 0;
}

static int sparse_setup(SUNLinearSolver solver, SUNMatrix J)
{
  nsdae_sparse_lu *lu = solver->content;
  return nsdae_sparse_lu_factor(lu, SUNDenseMatrix_Data(J), lu->n) == 0 ? 0 : 1;
}

static int sparse_solve(SUNLinearSolver solver, SUNMatrix J, N_Vector x, N_Vector b,
                        sunrealtype tol)
{
  (void)J;
  (void)tol;
  N_VScale(1, b, x);
  nsdae_sparse_lu_solve(solver->content, N_VGetArrayPointer(x));
  return 0;
}

static int sparse_free(SUNLinearSolver solver)
{
  SUNLinSolFreeEmpty(solver);
  return 0;
}

static void layout_sparse(void *object, nsdae_arena *arena)
{
  nsdae_sparse_lu_layout(object, arena);
}

static SUNLinearSolver make_sparse(nsdae_dae *dae)
{
  dae->lu.n = dae->problem.n;
  if (nsdae_arena_build(&dae->arena, layout_sparse, &dae->lu) < 0) return NULL;
  SUNLinearSolver solver = SUNLinSolNewEmpty(dae->context);
  if (!solver) return NULL;
  solver->content = &dae->lu;
  solver->ops->gettype = sparse_type;
  solver->ops->initialize = sparse_initialize;
  solver->ops->setup = sparse_setup;
  solver->ops->solve = sparse_solve;
  solver->ops->free = sparse_free;
  return solver;
}

static int make_solver(nsdae_dae *dae)
{
  sunindextype n = dae->problem.n;
  dae->matrix = SUNDenseMatrix(n, n, dae->context);
  if (!dae->matrix) return NSDAE_E_MEMORY;
  dae->solver =
      dae->problem.sparse ? make_sparse(dae) : SUNLinSol_Dense(dae->y, dae->matrix, dae->context);
  return dae->solver ? NSDAE_OK : NSDAE_E_MEMORY;
}

static int make_vectors(nsdae_dae *dae)
{
  int n = dae->problem.n;
  dae->y = nsdae_pool_vector(&dae->pool, n, dae->context);
  if (!dae->y) return NSDAE_E_MEMORY;
  dae->yp = nsdae_pool_vector(&dae->pool, n, dae->context);
  dae->order = nsdae_pool_vector(&dae->pool, n, dae->context);
  if (!dae->yp || !dae->order || nsdae_pool_fill(&dae->pool, dae->y) != 0) return NSDAE_E_MEMORY;
  memcpy(N_VGetArrayPointer(dae->order), dae->problem.order, (size_t)n * sizeof(double));
  return NSDAE_OK;
}

static int make_objects(nsdae_dae *dae)
{
  if (nsdae_make_context(&dae->context) != 0) return NSDAE_E_MEMORY;
  int status = make_vectors(dae);
  if (status == NSDAE_OK) status = make_solver(dae);
  if (status < 0) return status;
  dae->falling = malloc((size_t)(dae->problem.roots + 1) * sizeof *dae->falling);
  for (int i = 0; dae->falling && i < dae->problem.roots; i++) dae->falling[i] = -1;
  dae->ida = IDACreate(dae->context);
  return dae->falling && dae->ida ? NSDAE_OK : NSDAE_E_MEMORY;
}

static int set_up(nsdae_dae *dae, double rtol, double atol, double max_step)
{
  void *ida = dae->ida;
#if SUNDIALS_VERSION_MAJOR < 7
  IDASetErrFile(ida, NULL);
#endif
  int bad = IDAInit(ida, residual, 0, dae->y, dae->yp);
  if (!bad) bad = IDASStolerances(ida, rtol, atol);
  if (!bad) bad = IDASetUserData(ida, dae);
  if (!bad) bad = IDASetLinearSolver(ida, dae->solver, dae->matrix);
  if (!bad) bad = IDASetJacFn(ida, jacobian);
  if (!bad) bad = IDASetId(ida, dae->order);
  /* an algebraic variable is as good as the state that it follows from, and may jump */
  if (!bad) bad = IDASetSuppressAlg(ida, SUNTRUE);
  if (!bad) bad = IDASetMaxNumSteps(ida, -1);
  if (!bad) bad = IDASetMaxStep(ida, max_step);
  if (dae->problem.roots > 0) {
    if (!bad) bad = IDARootInit(ida, dae->problem.roots, root);
    if (!bad) bad = IDASetRootDirection(ida, dae->falling);
    if (!bad) bad = IDASetNoInactiveRootWarn(ida);
  }
  return bad ? NSDAE_E_MEMORY : NSDAE_OK;
}

int nsdae_dae_create(const nsdae_dae_problem *problem, double rtol, double atol, double max_step,
                     nsdae_dae **dae)
{
  *dae = NULL;
  nsdae_dae *made = calloc(1, sizeof *made);
  if (!made) return NSDAE_E_MEMORY;
  made->problem = *problem;
  int status = make_objects(made);
  if (status == NSDAE_OK) status = set_up(made, rtol, atol, max_step);
  if (status < 0)
    nsdae_dae_destroy(&made);
  else
    *dae = made;
  return status;
}

void nsdae_dae_destroy(nsdae_dae **dae)
{
  nsdae_dae *old = dae ? *dae : NULL;
  if (!old) return;
  if (old->ida) IDAFree(&old->ida);
  if (old->solver) SUNLinSolFree(old->solver);
  if (old->matrix) SUNMatDestroy(old->matrix);
  if (old->order) N_VDestroy(old->order);
  if (old->yp) N_VDestroy(old->yp);
  if (old->y) N_VDestroy(old->y);
  nsdae_pool_close(&old->pool);
  if (old->context) SUNContext_Free(&old->context);
  free(old->falling);
  nsdae_arena_release(&old->arena);
  free(old);
  *dae = NULL;
}

static int failure(const nsdae_dae *dae)
{
  return dae->progress.failed ? NSDAE_E_CALLBACK : NSDAE_E_CONVERGENCE;
}

static int reinit(nsdae_dae *dae, double t, const double *y, const double *yp)
{
  size_t size = (size_t)dae->problem.n * sizeof *y;
  memcpy(N_VGetArrayPointer(dae->y), y, size);
  memcpy(N_VGetArrayPointer(dae->yp), yp, size);
  return IDAReInit(dae->ida, t, dae->y, dae->yp);
}

/* Newton's method came to its end without a reason in a callback: where a force is nearly zero its
 * rounding can be above what rtol and atol ask for. */
static int came_to_rest(const nsdae_dae *dae, int code)
{
  return !dae->progress.failed && !dae->progress.refused &&
         (code == IDA_LINESEARCH_FAIL || code == IDA_CONV_FAIL);
}

int nsdae_dae_start(nsdae_dae *dae, double t, double after, double *y, double *yp, int *code)
{
  size_t size = (size_t)dae->problem.n * sizeof *y;
  dae->progress = (nsdae_progress){0};
  if (dae->problem.sparse) nsdae_sparse_lu_forget(&dae->lu);
  dae->after = after;
  *code = reinit(dae, t, y, yp);
  if (*code == 0) *code = IDACalcIC(dae->ida, IDA_YA_YDP_INIT, after);
  if (*code == 0)
    *code = IDAGetConsistentIC(dae->ida, dae->y, dae->yp);
  else if (came_to_rest(dae, *code))
    *code = reinit(dae, t, y, yp);
  if (*code != 0) return failure(dae);
  memcpy(y, N_VGetArrayPointer(dae->y), size);
  memcpy(yp, N_VGetArrayPointer(dae->yp), size);
  return NSDAE_OK;
}

int nsdae_dae_advance(nsdae_dae *dae, double *t, int *root_found, int *found, int *code)
{
  double from = *t;
  nsdae_progress_begin(&dae->progress);
  *code = IDASolve(dae->ida, dae->after, t, dae->y, dae->yp, IDA_ONE_STEP);
  *root_found = *code == IDA_ROOT_RETURN;
  if (nsdae_progress_lost(&dae->progress, *t > from || *root_found) && *code >= 0)
    *code = IDA_CONV_FAIL;
  if (*code < 0) return failure(dae);
  if (*root_found) IDAGetRootInfo(dae->ida, found);
  return NSDAE_OK;
}

int nsdae_dae_interpolate(nsdae_dae *dae, double t, int derivative, double *y)
{
  N_Vector out = derivative ? dae->yp : dae->y;
  if (IDAGetDky(dae->ida, t, derivative, out) != 0) return NSDAE_E_CONVERGENCE;
  memcpy(y, N_VGetArrayPointer(out), (size_t)dae->problem.n * sizeof *y);
  return NSDAE_OK;
}
