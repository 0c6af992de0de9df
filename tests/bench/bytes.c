/* Hashes of steps: of each scene by each method one line with the FNV-1a hash (Fowler, Noll, Vo,
 * 1991) of the bytes of q, v, multipliers, impulses and modes of every record, and of the error of
 * a step that fails. Two builds with the same lines take the same steps to the last bit: bytes.sh.
 */
#include <limits.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "arch.h"
#include "bouncing_ball.h"
#include "clearance_hinge.h"
#include "column.h"
#include "crank_slider.h"
#include "disks.h"
#include "dominoes.h"
#include "falling_rod.h"
#include "flexible_crank.h"
#include "heap.h"
#include "incline.h"
#include "newtons_cradle.h"
#include "pendulum.h"
#include "random_system.h"
#include "rolling_ball.h"
#include "shaken_ball.h"
#include "squeezer.h"
#include "twin.h"
#include "wall.h"
#include "woodpecker.h"

static const driver_model *const models[] = {
    &arch_model,         &bouncing_ball_model, &clearance_hinge_model, &column_model,
    &crank_slider_model, &dominoes_model,      &falling_rod_model,     &flexible_crank_model,
    &heap_model,         &incline_model,       &newtons_cradle_model,  &pendulum_model,
    &rolling_ball_model, &shaken_ball_model,   &squeezer_model,        &wall_model,
    &woodpecker_model};

enum { MODELS = sizeof models / sizeof *models };

/* Sizes of twins: one block; small, in two and three dimensions; with frictional joints; large. */
static const twin_kind kinds[] = {
    {.blocks = 1, .largest = 3, .k = 2, .nt = 1, .friction = 0.3},
    {.blocks = 4, .largest = 3, .joined = 1, .k = 4, .nt = 1, .friction = 0.4, .restitution = 0.8},
    {.blocks = 5, .largest = 7, .joined = 1, .k = 5, .nt = 2, .friction = 0.2},
    {.blocks = 4, .largest = 3, .joined = 1, .k = 2, .nt = 1, .friction = 0.2, .f = 2},
    {.blocks = 6, .largest = 6, .joined = 1, .k = 6, .nt = 2, .friction = 0.5, .f = 2},
    {.blocks = 40, .largest = 3, .joined = 1, .k = 40, .nt = 1, .friction = 0.2, .restitution = 1},
    {.blocks = 30, .largest = 7, .joined = 1, .k = 30, .nt = 2, .friction = 0.2}};

enum { KINDS = sizeof kinds / sizeof *kinds, STEPS = 120, SEEDS = 40, TWIN_SEEDS = 3 };

static uint64_t hash;

static void add(const void *bytes, size_t size)
{
  const unsigned char *b = bytes;
  for (size_t i = 0; b && i < size; i++) hash = (hash ^ b[i]) * UINT64_C(1099511628211);
}

static void add_reals(const double *a, int count)
{
  add(a, (size_t)count * sizeof *a);
}

static int add_record(const nsdae_record *r, const nsdae_dims *d)
{
  add_reals(r->q, d->nq), add_reals(r->v, d->nv), add_reals(r->multiplier, d->m);
  add_reals(r->frictional_joint_impulse, d->f);
  add_reals(r->normal_impulse, d->k), add_reals(r->tangential_impulse, d->k * d->nt);
  if (r->mode) add(r->mode, (size_t)d->k * sizeof *r->mode);
  for (int i = 0; i < r->contacts.count; i++) {
    add_reals(&r->contacts.normal_impulse[i], 1);
    add_reals(r->contacts.tangential_impulse + i * d->nt, d->nt);
    add(&r->contacts.mode[i], sizeof *r->contacts.mode);
  }
  add_reals(&r->lcp_residual, 1);
  return r->impacts;
}

static int steps(nsdae_sim *sim, int most)
{
  nsdae_dims dims;
  nsdae_record r;
  nsdae_sim_get_dims(sim, &dims);
  int status = NSDAE_OK, impacts = 0;
  for (int n = 0; n < most && status >= 0; n++) {
    status = nsdae_sim_step(sim);
    if (status < 0) add(nsdae_sim_error(sim)->text, strlen(nsdae_sim_error(sim)->text));
    nsdae_sim_get_record(sim, &r);
    impacts += add_record(&r, &dims);
  }
  return impacts;
}

/* Steps by event: it has one dense problem for all contacts that touch, and takes few of disks. */
static int event_most = INT_MAX;

/* The scene by every method and, of those by time steps, with projections and polygons. */
static void run(const char *name, nsdae_system *system, const double *q, const double *v,
                nsdae_sim_options options, int most)
{
  nsdae_dims d = {0};
  if (system) nsdae_system_get_dims(system, &d);
  for (int run = 0; system && run < 8; run++) {
    static const int by[] = {NSDAE_METHOD_IMPLICIT, NSDAE_METHOD_IMPLICIT_PRINTED,
                             NSDAE_METHOD_MOREAU,   NSDAE_METHOD_PENALTY,
                             NSDAE_METHOD_EVENT,    NSDAE_METHOD_MOREAU,
                             NSDAE_METHOD_IMPLICIT, NSDAE_METHOD_EVENT};
    nsdae_sim *sim = NULL;
    nsdae_error error = {0};
    int impacts = 0;
    options.method = by[run];
    options.projection = run == 5 ? NSDAE_PROJECTION_DEPTHS : NSDAE_PROJECTION_NONE;
    options.polygon = run > 5 ? 6 : 0;
    hash = UINT64_C(14695981039346656037);
    int status = nsdae_sim_create(system, &options, &sim, &error);
    if (status == NSDAE_OK) status = nsdae_sim_init(sim, 0, q, v);
    /* penalty asks for a list thousands of times an impact: one step */
    int few = by[run] == NSDAE_METHOD_EVENT && event_most < most ? event_most : most;
    if (d.k == 0 && by[run] == NSDAE_METHOD_PENALTY) few = 1;
    if (status >= 0) impacts = steps(sim, few);
    printf("%-32s %d %016llx %d\n", name, run, (unsigned long long)hash, impacts);
    nsdae_sim_destroy(&sim);
  }
  nsdae_system_destroy(&system);
}

static void run_model(const driver_model *m)
{
  nsdae_sim_options o;
  nsdae_error error;
  nsdae_system *system = NULL;
  static double q[4096], v[4096];
  memset(q, 0, sizeof q), memset(v, 0, sizeof v);
  nsdae_sim_options_default(&o);
  if (m->dt > 0) o.dt = m->dt;
  nsdae_params_default(m->parameters, m->base);
  if (m->build(m->base, &system, &error) < 0) return;
  m->start(m->base, q, v);
  int large = m == &heap_model || m == &wall_model || m == &arch_model || m == &column_model;
  run(m->name, system, q, v, o, large ? 12 : 4 * STEPS);
}

static void run_twins(int kind, uint64_t seed)
{
  static const char *const as[] = {"dense", "fixed over blocks", "list"};
  nsdae_sim_options o;
  nsdae_sim_options_default(&o);
  o.dt = 2e-3, o.rank_tol = 1e-12, o.start_tol = 1;
  for (int i = 0; i < 3; i++) {
    static twin t;
    char name[64];
    twin_draw(&t, 500 + 100 * (uint64_t)kind + seed, &kinds[kind]);
    snprintf(name, sizeof name, "twin %d %d %s", kind, (int)seed, as[i]);
    run(name,
        i == 0   ? twin_dense(&t)
        : i == 1 ? twin_numbered(&t, TWIN_BY_ROWS)
                 : twin_blocks(&t),
        t.q0, t.v0, o, 30);
  }
}

static void run_random(uint64_t seed)
{
  static random_system r;
  char name[64];
  nsdae_sim_options o;
  nsdae_sim_options_default(&o);
  random_system_draw(&r, seed, RANDOM_PLAIN);
  snprintf(name, sizeof name, "random %d", (int)seed);
  run(name, random_system_make(&r), r.q0, r.v0, o, STEPS);
}

static void run_disks(int n)
{
  disks d;
  char name[64];
  static double q[4096], v[4096];
  nsdae_sim_options o;
  nsdae_sim_options_default(&o);
  disks_create(&d, n, 10);
  disks_start(&d, q, v);
  snprintf(name, sizeof name, "disks %d", n);
  run(name, disks_system(&d), q, v, o, 4 * STEPS);
  disks_destroy(&d);
}

int main(void)
{
  for (int i = 0; i < MODELS; i++) run_model(models[i]);
  for (int kind = 0; kind < KINDS; kind++)
    for (uint64_t seed = 0; seed < TWIN_SEEDS; seed++) run_twins(kind, seed);
  for (uint64_t seed = 0; seed < SEEDS; seed++) run_random(seed);
  event_most = 12;
  run_disks(10);
  run_disks(100);
  return 0;
}
