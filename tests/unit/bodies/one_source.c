/* One mechanism, its contacts described by nsdae_bodies_add_contact, by nsdae_bodies_set_pair or by
 * both: the same gaps, directions, velocities and accelerations, to the last bit, each contact
 * once. */
#include "check.h"

#include <nsdae/nsdae.h>

#include "bodies_impl.h"
#include "lists.h"
#include "maker.h"
#include "support/random.h"

enum { BODIES = 3, SOLIDS_MAX = 9, NQ_MAX = 7 * BODIES, NV_MAX = 6 * BODIES, K_MAX = 4000 };
enum { MECHANISMS = 300 };

/* Every pair of solids by its number; by their material; the pairs with solid 0 by their number,
 * the others by their material. */
enum { FIXED, LISTED, MIXED };

static uint64_t seed;

static double uniform(double low, double high)
{
  return random_between(&seed, low, high);
}

static const double corners[8] = {-0.5, -0.4, 0.6, -0.3, 0.5, 0.5, -0.4, 0.3};

static int is_base(const nsdae_solid_of *s)
{
  return s->shape == NSDAE_SHAPE_PLANE || s->hollow;
}

static void add_solid(nsdae_bodies *b, int body)
{
  static const int shapes[2][5] = {{NSDAE_SHAPE_POINT, NSDAE_SHAPE_DISC, NSDAE_SHAPE_SEGMENT,
                                    NSDAE_SHAPE_POLYGON, NSDAE_SHAPE_PLANE},
                                   {NSDAE_SHAPE_POINT, NSDAE_SHAPE_SPHERE, NSDAE_SHAPE_CAPSULE,
                                    NSDAE_SHAPE_BOX, NSDAE_SHAPE_PLANE}};
  int d = b->dimension, shape = random_below(&seed, uniform(0, 1) < 0.2 ? 5 : 4);
  nsdae_solid s = {.shape = shapes[d - 2][shape],
                   .radius = shape == 0 || shape == 3 ? 0 : uniform(0.1, 0.5),
                   .length = {uniform(0.5, 2), uniform(0.5, 2), uniform(0.5, 2)},
                   .hollow = uniform(0, 1) < 0.1,
                   .points = 4,
                   .point = corners,
                   .angle = uniform(-3, 3)};
  if (s.hollow) s.radius = 3;
  for (int i = 0; i < d; i++) s.position[i] = uniform(-0.5, 0.5);
  for (int i = 0; i < 4; i++) s.quaternion[i] = uniform(-1, 1);
  if (d == 2) memset(s.quaternion, 0, sizeof s.quaternion);
  if (d == 3) s.angle = 0;
  assert_true(nsdae_bodies_add_solid(b, body, &s) >= 0);
}

/* The same bodies for one number, in motion, some of them on each other. */
static nsdae_bodies *mechanism(int d, int number, int form)
{
  nsdae_bodies *b;
  seed = 10000 * (uint64_t)d + (uint64_t)number;
  assert_int_equal(nsdae_bodies_create(d, &b, NULL), NSDAE_OK);
  for (int i = 0; i < BODIES; i++) {
    nsdae_rigid_body body = {.mass = 1, .inertia = {1, 2, 1.5}, .angle = uniform(-3, 3)};
    for (int j = 0; j < d; j++) body.position[j] = uniform(-1.5, 1.5);
    for (int j = 0; j < d; j++) body.velocity[j] = uniform(-1, 1);
    for (int j = d == 2 ? 2 : 0; j < 3; j++) body.spin[j] = uniform(-2, 2);
    for (int j = 0; j < 4; j++) body.quaternion[j] = uniform(-1, 1);
    if (d == 2) memset(body.quaternion, 0, sizeof body.quaternion);
    if (d == 3) body.angle = 0;
    assert_int_equal(nsdae_bodies_add(b, &body), i);
  }
  for (int i = -1; i < BODIES; i++)
    for (int j = 1 + random_below(&seed, 2); j > 0; j--) add_solid(b, i);
  const nsdae_solid_of *s = b->solid.at;
  for (int i = 0; i < b->solid.count; i++)
    for (int j = i + 1; j < b->solid.count; j++) {
      int named = form == FIXED || (form == MIXED && i == 0);
      if (!named || s[i].body == s[j].body || (is_base(&s[i]) && is_base(&s[j]))) continue;
      int turned = form == MIXED && d == 2 && number % 2; /* in space edges turn u_2 over with it */
      double e_t = form == MIXED ? 0.25 : 0;
      assert_true(nsdae_bodies_add_contact(b, turned ? j : i, turned ? i : j, 0.3, 0.5, e_t) >= 0);
    }
  if (form != FIXED) assert_int_equal(nsdae_bodies_set_pair(b, 0, 0, 0.3, 0.5, 0), NSDAE_OK);
  return b;
}

/* Fixed contacts at a point. */
typedef struct fixed {
  nsdae_bodies *b;
  nsdae_system *system;
  nsdae_dims dims;
  double gap[K_MAX], W[3][K_MAX * NV_MAX], omega[3][K_MAX];
} fixed;

static void evaluate(fixed *f, const double *q, const double *v)
{
  static double tangents[2 * K_MAX * NV_MAX], omega_t[2 * K_MAX];
  int k = f->dims.k, nt = f->dims.nt, nv = f->dims.nv;
  size_t column = (size_t)nv * sizeof *tangents;
  const nsdae_calls *call = &f->system->call;
  assert_true(k <= K_MAX);
  memset(f->W, 0, sizeof f->W);
  memset(tangents, 0, sizeof tangents);
  assert_int_equal(call->gap(0, q, f->gap, &f->b->force.user), 0);
  assert_int_equal(call->gap_normal(0, q, f->W[0], nv, &f->b->force.user), 0);
  assert_int_equal(call->gap_tangent(0, q, tangents, nv, &f->b->force.user), 0);
  assert_int_equal(
      call->contact_acceleration(0, q, v, f->omega[0], omega_t, NULL, &f->b->force.user), 0);
  for (int i = 0; i < k * nt; i++) {
    memcpy(f->W[1 + i % nt] + i / nt * nv, tangents + i * nv, column);
    f->omega[1 + i % nt][i / nt] = omega_t[i];
  }
}

/* The same corner, or the same edges, of the same solids; round ones in either order. */
static int is_same(const nsdae_bodies *b, const nsdae_feature *x, const nsdae_feature *y)
{
  const nsdae_solid_of *s = b->solid.at;
  int turned = x->solid[0] == y->solid[1] && x->solid[1] == y->solid[0];
  if (turned && s[x->solid[0]].points == 1 && s[x->solid[1]].points == 1) return 1;
  return x->edges == y->edges && x->part[0] == y->part[0] && x->part[1] == y->part[1] &&
         x->solid[0] == y->solid[0] && x->solid[1] == y->solid[1];
}

/* The fixed contact of an id in another form. */
static int find_fixed(const fixed *f, const nsdae_bodies *b, long id)
{
  long features = 1, edges = 0, solids = b->solid.count, pair;
  for (int i = 0; i < solids; i++) { /* as nsdae/bodies.h has it */
    const nsdae_solid_of *s = nsdae_solid_at(b, i);
    if (s->points > features) features = s->points;
    if (nsdae_solid_edges(s) > edges) edges = nsdae_solid_edges(s);
  }
  features = 2 * features + edges * edges;
  pair = (id - b->feature.count) / features;
  for (int i = 0; i < f->b->feature.count; i++) {
    const nsdae_feature *other = nsdae_feature_at(f->b, i);
    const int *s = other->solid, low = s[0] < s[1] ? s[0] : s[1], high = s[0] + s[1] - low;
    if (id < b->feature.count
            ? is_same(b, other, nsdae_feature_at(b, (int)id))
            : pair == low * solids + high && other->number == (id - b->feature.count) % features)
      return i;
  }
  fail_msg("no contact of id %ld", id);
  return -1;
}

static void compare(const fixed *f, const nsdae_contact_list *l, int i, int j, int omega)
{
  int nv = f->dims.nv, rows = 1 + f->dims.nt;
  assert_true(l->gap[i] == f->gap[j]);
  assert_int_equal(l->omega_given[i], omega);
  for (int d = 0; d < rows; d++) {
    double column[NV_MAX] = {0};
    for (int s = 2 * i; s < 2 * i + 2; s++)
      for (int n = 0, size = nsdae_body_nv(f->b); n < size && l->block[s] >= 0; n++)
        column[l->block[s] * size + n] += l->value[l->at[s] + (size_t)(d * size + n)];
    for (int n = 0; n < nv; n++) assert_true(column[n] == f->W[d][j * nv + n]);
    assert_true(l->w[i * rows + d] == 0);
    if (omega) assert_true(l->omega[i * rows + d] == f->omega[d][j]);
  }
}

static nsdae_contact_list empty_list(const nsdae_system *system, nsdae_error *error)
{
  const nsdae_room room = {K_MAX, K_MAX * 2 * 6 * 3};
  nsdae_contact_list list = {.blocks = &system->blocks, .nt = system->dims.nt, .error = error};
  assert_int_equal(nsdae_contact_list_grow(&list, &room), NSDAE_OK);
  return list;
}

/* Whether the gap of a fixed contact is that of its own feature. */
static int is_near(const fixed *f, int i, double reach)
{
  int nv = f->dims.nv, any = 0;
  for (int n = 0; n < nv; n++) any |= f->W[0][i * nv + n] != 0;
  return any && f->gap[i] <= reach;
}

/* How fast a gap of the list changes, in parts of contact_speed. */
static double fastest;

static void check_speed(const nsdae_system *system, const nsdae_contact_list *l, const double *q,
                        const double *v)
{
  double most, still[NV_MAX] = {0};
  assert_int_equal(system->call.contact_speed(0, q, still, &most, system->user), 0);
  assert_true(most == 0);
  assert_int_equal(system->call.contact_speed(0, q, v, &most, system->user), 0);
  for (int i = 0; i < l->count; i++) {
    double rate = fabs(nsdae_contact_list_velocity(l, i, 0, v));
    assert_true(rate <= most);
    fastest = fmax(fastest, rate / most);
  }
}

/* Those by material whose place is in a third solid are hidden (seams.h). */
static int compared, hidden;

/* A fixed contact that the other form does not list: it was not asked for by name, and there is a
 * third flat solid on another body than the one that is touched. */
static void expect_hidden(const fixed *f, const nsdae_bodies *b, int j)
{
  const nsdae_feature *missing = nsdae_feature_at(f->b, j);
  const nsdae_solid_of *s = b->solid.at;
  int covers = 0;
  for (int i = 0; i < b->feature.count; i++)
    assert_false(is_same(b, missing, nsdae_feature_at(b, i)));
  for (int k = 0; k < b->solid.count; k++)
    for (int side = 0; side < 2; side++)
      covers |= k != missing->solid[0] && k != missing->solid[1] &&
                (s[k].points > 1 || s[k].shape == NSDAE_SHAPE_PLANE) &&
                s[k].body != s[missing->solid[side]].body;
  assert_true(covers);
  hidden++;
}

static void check_form(const fixed *f, int number, int form, const double *q, const double *v,
                       int omega)
{
  nsdae_bodies *b = mechanism(f->b->dimension, number, form);
  nsdae_system *system;
  nsdae_error error;
  double reach = uniform(0, 0.5);
  int seen[K_MAX] = {0};
  assert_true(nsdae_bodies_system(b, &system) >= 0);
  assert_int_equal(system->dims.k, 0);
  nsdae_contact_list list = empty_list(system, &error);
  nsdae_contact_list_clear(&list);
  list.without_omega = !omega;
  assert_int_equal(system->call.contacts(0, q, v, reach, &list, &b->force.user), 0);
  assert_true(list.status == NSDAE_OK && nsdae_room_enough(&list.room, &list.taken));
  for (int i = 0; i < list.count; i++) {
    int j = find_fixed(f, b, list.id[i]), named = list.id[i] < b->feature.count;
    char words[128];
    assert_true(list.gap[i] <= reach && seen[j]++ == 0);
    compare(f, &list, i, j, omega);
    assert_true(list.law[i].mu == 0.3 && list.law[i].e_n == 0.5);
    assert_true(list.law[i].e_t == (named ? 0.25 : 0));
    assert_true(system->maker.words(b, NSDAE_NAME_CONTACT, list.id[i], words, sizeof words));
    compared++;
  }
  check_speed(system, &list, q, v);
  for (int j = 0; j < f->dims.k; j++)
    if (is_near(f, j, reach - 1e-12) && !seen[j]) expect_hidden(f, b, j);
  nsdae_contact_list_release(&list);
  nsdae_system_destroy(&system);
  nsdae_bodies_destroy(&b);
}

static void check_family(int d)
{
  static fixed f;
  compared = hidden = 0;
  fastest = 0;
  for (int number = 0; number < MECHANISMS; number++) {
    double q[NQ_MAX], v[NV_MAX];
    f.b = mechanism(d, number, FIXED);
    assert_true(nsdae_bodies_system(f.b, &f.system) >= 0);
    nsdae_bodies_get_dims(f.b, &f.dims);
    nsdae_bodies_get_start(f.b, q, v);
    if (f.dims.k > 0) evaluate(&f, q, v);
    for (int form = LISTED; form <= MIXED; form++)
      for (int omega = 0; omega < 2; omega++) check_form(&f, number, form, q, v, omega);
    nsdae_system_destroy(&f.system);
    nsdae_bodies_destroy(&f.b);
  }
  assert_true(compared > 10 * MECHANISMS && fastest > 0.5);
  assert_true(20 * hidden <= compared); /* random solids overlap: a place in 25 is in a third one */
}

/* Points that fly at each other, one on an arm; a half-space on a body that turns, under a point at
 * the distance 2 of its centre: contact_speed is the rate of the gap. */
static void test_speed(void **state)
{
  (void)state;
  for (int plane = 0; plane < 2; plane++) {
    nsdae_bodies *b;
    nsdae_system *system;
    double q[9], v[9], speed;
    assert_int_equal(nsdae_bodies_create(2, &b, NULL), NSDAE_OK);
    for (int i = 0; i < 3; i++) { /* the third is the slowest */
      nsdae_rigid_body body = {.mass = 1, .inertia = {0, 0, 1}, .position = {2 * i, 0}};
      body.velocity[1] = i == 0 ? 1 : i == 1 ? -2 : 0.5;
      if (i == 0) body.spin[2] = 3;
      assert_int_equal(nsdae_bodies_add(b, &body), i);
      const nsdae_solid s = {.shape = plane && i == 0 ? NSDAE_SHAPE_PLANE : NSDAE_SHAPE_POINT,
                             .position = {!plane && i == 0 ? 0.5 : 0}};
      if (i < 2) assert_int_equal(nsdae_bodies_add_solid(b, i, &s), i);
    }
    assert_int_equal(nsdae_bodies_set_pair(b, 0, 0, 0, 0, 0), NSDAE_OK);
    assert_true(nsdae_bodies_system(b, &system) >= 0);
    assert_int_equal(nsdae_bodies_get_start(b, q, v), NSDAE_OK);
    assert_int_equal(system->call.contact_speed(0, q, v, &speed, &b->force.user), 0);
    assert_near(speed, 1 + 3 * (plane ? 2 : 0.5) + 2, 1e-14);
    nsdae_system_destroy(&system);
    nsdae_bodies_destroy(&b);
  }
}

static void test_planar(void **state)
{
  (void)state;
  check_family(2);
}

static void test_spatial(void **state)
{
  (void)state;
  check_family(3);
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_planar), cmocka_unit_test(test_spatial),
                                     cmocka_unit_test(test_speed)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
