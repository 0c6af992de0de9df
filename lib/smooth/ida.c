/* See ida.h. SUNDIALS 6.4 and 7. Newton's matrix is the caller's: an empty SUNMatrix, and a direct
 * SUNLinearSolver whose two calls are the caller's setup and solve. Vectors, matrix and solver are
 * parts of the record, not made by SUNDIALS: where the second of its two allocations for one fails,
 * version 7 loses the first, or follows the null pointer if it was built without error checks. */
#include "ida.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <ida/ida.h>
#include <nvector/nvector_serial.h>
#include <sundials/sundials_context.h>
#include <sundials/sundials_version.h>

#include "stalled_steps.h"
#include "vector.h"

/* Vectors that IDA clones and those of here: 24 with 6.4 and 7. */
enum { VECTORS = 32 };

/* A serial vector of the pool. */
typedef struct pooled {
  struct _N_VectorContent_Serial serial; /* first: what SUNDIALS takes for the content */
  struct _generic_N_Vector vector;
  struct pooled *pool; /* the first one */
  int differential, in_use;
} pooled;

struct nsdae_ida {
  nsdae_ida_problem problem;
  nsdae_ida_tolerances tolerances;
  SUNContext context;
  void *ida;
  pooled pool[VECTORS];
  double *data;                       /* VECTORS n: the entries of the vectors */
  N_Vector y, ydot, between, differs; /* where it is; where it is read; 1: differential */
  struct _generic_SUNMatrix matrix;
  struct _generic_SUNLinearSolver solver;
  double t, way; /* where it is; l of runge_kutta.h */
  long failed;   /* error tests since the start */
  int held;      /* steps that must not grow */
  int flag;      /* of the last step */
  nsdae_progress progress;
};

/* ---- vectors: N_VClone of SUNDIALS does not survive a clone that fails, so that all are there
 * from the start. They live as long as the pool, and one may be destroyed twice, as IDAInit does
 * when it finds no memory. */

static N_Vector take(pooled *pool)
{
  for (int i = 0; i < VECTORS; i++) {
    if (pool[i].in_use) continue;
    pool[i].in_use = 1;
    return &pool[i].vector;
  }
  return NULL;
}

static N_Vector duplicate(N_Vector like)
{
  return take(((pooled *)like->content)->pool);
}

static void give_back(N_Vector vector)
{
  ((pooled *)vector->content)->in_use = 0;
}

/* sqrt(sum (w_i x_i)^2 / d) of d differential unknowns: an unknown of an open contact, which is
 * zero, changes no bit of it. IDA's own mean is over the length. */
static sunrealtype norm_of(N_Vector x, N_Vector weights, sunindextype count)
{
  const double *at = N_VGetArrayPointer(x), *w = N_VGetArrayPointer(weights);
  double sum = 0;
  for (sunindextype i = 0; i < count; i++) sum += (at[i] * w[i]) * (at[i] * w[i]);
  return sqrt(sum / ((pooled *)x->content)->differential);
}

static sunrealtype norm(N_Vector x, N_Vector weights)
{
  return norm_of(x, weights, NV_LENGTH_S(x));
}

/* Of the differential unknowns, which are the first. */
static sunrealtype differential_norm(N_Vector x, N_Vector weights, N_Vector differs)
{
  (void)differs;
  return norm_of(x, weights, ((pooled *)x->content)->differential);
}

/* What IDA and its Newton iteration call. */
static const struct _generic_N_Vector_Ops vector_ops = {.nvgetvectorid = N_VGetVectorID_Serial,
                                                        .nvclone = duplicate,
                                                        .nvdestroy = give_back,
                                                        .nvgetarraypointer =
                                                            N_VGetArrayPointer_Serial,
                                                        .nvgetlength = N_VGetLength_Serial,
                                                        .nvlinearsum = N_VLinearSum_Serial,
                                                        .nvconst = N_VConst_Serial,
                                                        .nvprod = N_VProd_Serial,
                                                        .nvdiv = N_VDiv_Serial,
                                                        .nvscale = N_VScale_Serial,
                                                        .nvabs = N_VAbs_Serial,
                                                        .nvinv = N_VInv_Serial,
                                                        .nvaddconst = N_VAddConst_Serial,
                                                        .nvmaxnorm = N_VMaxNorm_Serial,
                                                        .nvwrmsnorm = norm,
                                                        .nvwrmsnormmask = differential_norm,
                                                        .nvmin = N_VMin_Serial};

static void make_vectors(nsdae_ida *s)
{
  sunindextype n = s->problem.n;
  for (int i = 0; i < VECTORS; i++) {
    pooled *p = &s->pool[i];
    p->serial.length = n;
    p->serial.data = s->data + (size_t)i * (size_t)n;
    p->vector = (struct _generic_N_Vector){
        .content = p, .ops = (N_Vector_Ops)&vector_ops, .sunctx = s->context};
    p->pool = s->pool;
    p->differential = s->problem.differential;
  }
  s->y = take(s->pool);
  s->ydot = take(s->pool);
  s->between = take(s->pool);
  s->differs = take(s->pool);
  for (int i = 0; i < s->problem.differential; i++) NV_Ith_S(s->differs, i) = 1;
}

/* ---- callbacks of IDA */

static double current_cj(const nsdae_ida *s)
{
  double cj = 0;
  IDAGetCurrentCj(s->ida, &cj);
  return cj;
}

static int residual(sunrealtype t, N_Vector y, N_Vector ydot, N_Vector r, void *user)
{
  nsdae_ida *s = user;
  int code = s->problem.residual(t, N_VGetArrayPointer(y), N_VGetArrayPointer(ydot), current_cj(s),
                                 N_VGetArrayPointer(r), s->problem.user);
  return nsdae_progress_note(&s->progress, code);
}

static double last_step(const nsdae_ida *s)
{
  double h = 0;
  IDAGetLastStep(s->ida, &h);
  return h;
}

/* Impulses are not fed back: see runge_kutta.c. */
static const double IMPULSE = 10;

static int weigh(N_Vector y, N_Vector weights, void *user)
{
  const nsdae_ida *s = user;
  const nsdae_ida_problem *p = &s->problem;
  const nsdae_ida_tolerances *tol = &s->tolerances;
  double h = last_step(s);
  double *w = N_VGetArrayPointer(weights);
  const double *at = N_VGetArrayPointer(y);
  for (int i = 0; i < p->differential; i++) {
    double scale = i < p->positions ? fmin(fabs(at[i]), s->way) : fabs(at[i]);
    w[i] = 1 / (tol->rtol * scale + tol->atol);
  }
  double force = fmax(tol->force, nsdae_largest(p->n - p->differential, at + p->differential));
  double most = IMPULSE * tol->rtol * force * (h > 0 ? fmax(1, tol->longest / h) : 1) + tol->atol;
  for (int i = p->differential; i < p->n; i++) w[i] = 1 / most;
  return 0;
}

static int setup(sunrealtype t, sunrealtype cj, N_Vector y, N_Vector ydot, N_Vector r,
                 SUNMatrix matrix, void *user, N_Vector room_1, N_Vector room_2, N_Vector room_3)
{
  nsdae_ida *s = user;
  (void)r, (void)matrix, (void)room_1, (void)room_2, (void)room_3;
  int code =
      s->problem.setup(t, N_VGetArrayPointer(y), N_VGetArrayPointer(ydot), cj, s->problem.user);
  return nsdae_progress_note(&s->progress, code);
}

/* ---- matrix and linear solver */

static SUNMatrix_ID matrix_id(SUNMatrix matrix)
{
  (void)matrix;
  return SUNMATRIX_CUSTOM;
}

static int zero(SUNMatrix matrix)
{
  (void)matrix;
  return 0;
}

static SUNLinearSolver_Type solver_type(SUNLinearSolver solver)
{
  (void)solver;
  return SUNLINEARSOLVER_DIRECT;
}

static int set_up_solver(SUNLinearSolver solver, SUNMatrix matrix)
{
  (void)solver, (void)matrix;
  return 0;
}

/* IDA 7 takes codes that it does not know for success: both here are its own, with every version.
 */
static int solve(SUNLinearSolver solver, SUNMatrix matrix, N_Vector x, N_Vector r, sunrealtype tol)
{
  nsdae_ida *s = solver->content;
  (void)matrix, (void)tol;
  int code = s->problem.solve(current_cj(s), N_VGetArrayPointer(r), N_VGetArrayPointer(x),
                              s->problem.user);
  nsdae_progress_note(&s->progress, code);
  return code == 0 ? 0 : code > 0 ? SUNLS_LUFACT_FAIL : SUNLS_GS_FAIL;
}

static const struct _generic_SUNMatrix_Ops matrix_ops = {.getid = matrix_id, .zero = zero};

static const struct _generic_SUNLinearSolver_Ops solver_ops = {
    .gettype = solver_type, .setup = set_up_solver, .solve = solve};

/* ---- creation */

/* More than what a context, IDA's record and its Newton iteration take together (some 10 kB). */
enum { RESERVE = 65536 };

/* A context that prints nothing: version 7 takes a communicator and reports through the context,
 * version 6 through IDA, which is silenced by IDASetErrFile. Up to 6.4 SUNContext_Create does not
 * survive a lost allocation in its logger, IDACreate prints, and version 7's IDAInit loses a block
 * of its Newton iteration: if the reserve is not to be had, they are not called. */
static int make_context(SUNContext *context)
{
  void *reserve = malloc(RESERVE);
  if (!reserve) return NSDAE_E_MEMORY;
  free(reserve);
#if SUNDIALS_VERSION_MAJOR >= 7
  if (SUNContext_Create(SUN_COMM_NULL, context) != 0) return NSDAE_E_MEMORY;
  return SUNContext_ClearErrHandlers(*context) == 0 ? NSDAE_OK : NSDAE_E_MEMORY;
#else
  return SUNContext_Create(NULL, context) == 0 ? NSDAE_OK : NSDAE_E_MEMORY;
#endif
}

static int make_integrator(nsdae_ida *s)
{
  s->ida = IDACreate(s->context);
  if (!s->ida) return NSDAE_E_MEMORY;
#if SUNDIALS_VERSION_MAJOR < 7
  IDASetErrFile(s->ida, NULL);
#endif
  int bad = IDAInit(s->ida, residual, 0, s->y, s->ydot);
  if (!bad) bad = IDAWFtolerances(s->ida, weigh);
  if (!bad) bad = IDASetUserData(s->ida, s);
  if (!bad) bad = IDASetId(s->ida, s->differs);
  if (!bad) bad = IDASetSuppressAlg(s->ida, 1);
  if (!bad) bad = IDASetLinearSolver(s->ida, &s->solver, &s->matrix);
  if (!bad) bad = IDASetJacFn(s->ida, setup);
  if (!bad) bad = IDASetLinearSolutionScaling(s->ida, 0); /* it is for the change of cj */
  return bad ? NSDAE_E_MEMORY : NSDAE_OK;
}

int nsdae_ida_create(const nsdae_ida_problem *problem, nsdae_ida **ida)
{
  *ida = NULL;
  nsdae_ida *s = calloc(1, sizeof *s);
  if (!s) return NSDAE_E_MEMORY;
  s->problem = *problem;
  s->data = calloc((size_t)VECTORS * ((size_t)problem->n + 1), sizeof *s->data);
  int status = s->data ? make_context(&s->context) : NSDAE_E_MEMORY;
  if (status == NSDAE_OK) make_vectors(s);
  s->matrix = (struct _generic_SUNMatrix){.ops = (SUNMatrix_Ops)&matrix_ops, .sunctx = s->context};
  s->solver = (struct _generic_SUNLinearSolver){
      .content = s, .ops = (SUNLinearSolver_Ops)&solver_ops, .sunctx = s->context};
  if (status == NSDAE_OK) status = make_integrator(s);
  if (status == NSDAE_OK) *ida = s;
  if (status < 0) nsdae_ida_destroy(&s);
  return status;
}

void nsdae_ida_destroy(nsdae_ida **ida)
{
  nsdae_ida *s = ida ? *ida : NULL;
  if (!s) return;
  if (s->ida) IDAFree(&s->ida);
  if (s->context) SUNContext_Free(&s->context);
  free(s->data);
  free(s);
  *ida = NULL;
}

/* ---- a run */

static void measure_way(nsdae_ida *s)
{
  s->way = s->tolerances.longest * nsdae_largest(s->problem.positions, N_VGetArrayPointer(s->ydot));
}

int nsdae_ida_start(nsdae_ida *s, const nsdae_ida_tolerances *tolerances, double t, const double *y,
                    const double *ydot, double first)
{
  size_t bytes = (size_t)s->problem.n * sizeof *y;
  s->progress = (nsdae_progress){0};
  s->tolerances = *tolerances;
  s->t = t;
  s->failed = s->held = 0;
  memcpy(N_VGetArrayPointer(s->y), y, bytes);
  memcpy(N_VGetArrayPointer(s->ydot), ydot, bytes);
  measure_way(s);
  s->flag = IDAReInit(s->ida, t, s->y, s->ydot);
  if (s->flag == 0) s->flag = IDASetInitStep(s->ida, first);
  /* 0: no bound */
  if (s->flag == 0)
    s->flag = IDASetMaxStep(s->ida, isfinite(tolerances->step_max) ? tolerances->step_max : 0);
  return s->flag == 0 ? NSDAE_OK : NSDAE_E_CONVERGENCE;
}

/* IDA doubles a step whose error is small, and looks at the next order only after k + 2 equal steps
 * of order k. If each doubled step fails the error test, as at the end of a transient, it stays at
 * order 1. So after a step that failed the test first, k + 2 steps do not grow. */
static void hold_step(nsdae_ida *s)
{
  long failed = 0;
  int order = 1;
  double most = isfinite(s->tolerances.step_max) ? s->tolerances.step_max : 0; /* 0: no bound */
  IDAGetNumErrTestFails(s->ida, &failed);
  IDAGetLastOrder(s->ida, &order);
  if (failed > s->failed) {
    s->held = order + 2;
    IDASetMaxStep(s->ida, last_step(s));
  } else if (s->held > 0 && --s->held == 0) {
    IDASetMaxStep(s->ida, most);
  }
  s->failed = failed;
}

int nsdae_ida_advance(nsdae_ida *s, double *t)
{
  double from = s->t, reached = from;
  nsdae_progress_begin(&s->progress);
  /* the end is no more than a direction, and the length that the first step is a part of */
  double end = from + fmax(s->tolerances.longest, 1e-6 * fabs(from));
  s->flag = IDASolve(s->ida, end, &reached, s->y, s->ydot, IDA_ONE_STEP);
  if (nsdae_progress_lost(&s->progress, reached > from) && s->flag >= 0) s->flag = IDA_CONV_FAIL;
  if (s->flag >= 0) hold_step(s);
  if (s->flag < 0) {
    if (s->progress.failed) return nsdae_progress_status(s->progress.failed);
    return s->progress.refused ? NSDAE_E_CALLBACK : NSDAE_E_CONVERGENCE;
  }
  *t = s->t = reached;
  measure_way(s);
  return NSDAE_OK;
}

const char *nsdae_ida_failure(const nsdae_ida *s)
{
#define NAMED(flag) \
  {                 \
    flag, #flag     \
  }
  static const struct {
    int flag;
    const char *name;
  } known[] = {NAMED(IDA_TOO_MUCH_ACC), NAMED(IDA_ERR_FAIL),    NAMED(IDA_CONV_FAIL),
               NAMED(IDA_LINIT_FAIL),   NAMED(IDA_LSETUP_FAIL), NAMED(IDA_LSOLVE_FAIL),
               NAMED(IDA_RES_FAIL),     NAMED(IDA_REP_RES_ERR), NAMED(IDA_FIRST_RES_FAIL),
               NAMED(IDA_ILL_INPUT),    NAMED(IDA_BAD_EWT)};
#undef NAMED
  for (size_t i = 0; i < sizeof known / sizeof *known; i++)
    if (known[i].flag == s->flag) return known[i].name;
  return "IDA";
}

int nsdae_ida_read(nsdae_ida *s, double t, int derivative, double *y)
{
  N_Vector from = t != s->t ? s->between : derivative ? s->ydot : s->y;
  if (t != s->t && IDAGetDky(s->ida, t, derivative, from) != 0) return NSDAE_E_CONVERGENCE;
  memcpy(y, N_VGetArrayPointer(from), (size_t)s->problem.n * sizeof *y);
  return NSDAE_OK;
}
