#include "friction_families.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { FREEDOMS = 6, ROWS = 3, PART = FREEDOMS * ROWS, GROUND = -1 };

/* A sphere where radius > 0, else a box. */
typedef struct friction_body {
  double c[3];          /* centre [m] */
  double axis[3][3];    /* of a box */
  double half[3];       /* its half lengths [m] */
  double radius, mass;  /* [m], [kg] */
  double inertia[3][3]; /* about the centre, in the axes of the world [kg m^2] */
} friction_body;

static const double step = 5e-3, gravity = 9.81, pi = 3.14159265358979323846;

const char *friction_family_name(int family)
{
  static const char *const name[FRICTION_FAMILIES] = {"wall", "spheres", "tower", "storeys"};
  return name[family];
}

const char *friction_motion_name(int motion)
{
  static const char *const name[FRICTION_MOTIONS] = {"at rest", "tilted", "hit"};
  return name[motion];
}

const char *friction_grip_name(int grip)
{
  static const char *const name[FRICTION_GRIPS] = {"alike", "mixed", "beside"};
  return name[grip];
}

/* xorshift64* (Vigna, ACM Trans. Math. Softw. 42, 2016) */
static double uniform(friction_sample *s, double low, double high)
{
  s->state ^= s->state >> 12;
  s->state ^= s->state << 25;
  s->state ^= s->state >> 27;
  unsigned long long next = s->state * 2685821657736338717ull;
  return low + (high - low) * ((double)(next >> 11) * 0x1p-53);
}

static int pick(friction_sample *s, int count)
{
  return (int)(uniform(s, 0, 1) * count);
}

static void *grow(void *block, size_t count, size_t size)
{
  void *larger = realloc(block, (count > 0 ? count : 1) * size);
  if (!larger) {
    fprintf(stderr, "friction_families: no memory for %zu items\n", count);
    exit(1);
  }
  return larger;
}

static void cross(const double *a, const double *b, double *out)
{
  for (int i = 0; i < 3; i++)
    out[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
}

static double dot(const double *a, const double *b)
{
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void normalise(double *a)
{
  double size = sqrt(dot(a, a));
  for (int i = 0; i < 3; i++) a[i] /= size;
}

/* Bodies. */

/* Densities of 1000 kg / m^3 and up to mass_ratio times more, evenly in the logarithm. */
static friction_body *add_body(friction_sample *s, double volume)
{
  s->body = grow(s->body, (size_t)s->bodies + 1, sizeof *s->body);
  friction_body *b = &s->body[s->bodies++];
  memset(b, 0, sizeof *b);
  b->mass = 1000 * volume * pow(s->mass_ratio, uniform(s, 0, 1));
  return b;
}

static int add_sphere(friction_sample *s, const double *c, double radius)
{
  friction_body *b = add_body(s, 4 * pi / 3 * pow(radius, 3));
  b->radius = radius;
  memcpy(b->c, c, sizeof b->c);
  for (int i = 0; i < 3; i++) b->inertia[i][i] = 0.4 * b->mass * radius * radius;
  return s->bodies - 1;
}

/* A box turned by an angle about the vertical. */
static int add_box(friction_sample *s, const double *c, const double *half, double angle)
{
  friction_body *b = add_body(s, 8 * half[0] * half[1] * half[2]);
  const double axis[3][3] = {{cos(angle), sin(angle), 0}, {-sin(angle), cos(angle), 0}, {0, 0, 1}};
  double square = 0;
  memcpy(b->c, c, sizeof b->c);
  memcpy(b->half, half, sizeof b->half);
  memcpy(b->axis, axis, sizeof b->axis);
  for (int k = 0; k < 3; k++) square += half[k] * half[k];
  for (int k = 0; k < 3; k++)
    for (int i = 0; i < 3; i++)
      for (int j = 0; j < 3; j++)
        b->inertia[i][j] += b->mass / 3 * (square - half[k] * half[k]) * axis[k][i] * axis[k][j];
  return s->bodies - 1;
}

/* Contacts. */

static void make_room(friction_sample *s)
{
  if (s->problem.contacts < s->room) return;
  s->room = 2 * s->room + 64;
  size_t room = (size_t)s->room;
  s->first = grow(s->first, room + 1, sizeof *s->first);
  s->block = grow(s->block, 2 * room, sizeof *s->block);
  s->mu = grow(s->mu, room, sizeof *s->mu);
  s->w = grow(s->w, ROWS * room, sizeof *s->w);
  s->value = grow(s->value, 2 * PART * room, sizeof *s->value);
}

/* The part of a body in the directions, with its sign: columns (d, (p - c) x d). */
static void add_part(friction_sample *s, int body, double sign, const double *p, double frame[3][3])
{
  int *end = &s->first[s->problem.contacts + 1];
  double arm[3], turn[3], *part = s->value + (size_t)*end * PART;
  for (int i = 0; i < 3; i++) arm[i] = p[i] - s->body[body].c[i];
  for (int d = 0; d < ROWS; d++) {
    cross(arm, frame[d], turn);
    for (int i = 0; i < 3; i++) {
      part[d * FREEDOMS + i] = sign * frame[d][i];
      part[d * FREEDOMS + 3 + i] = sign * turn[i];
    }
  }
  s->block[(*end)++] = body;
}

/* A contact at p with the unit normal e from body a to body b; a may be the ground. */
static void add_contact(friction_sample *s, int a, int b, const double *p, const double *e)
{
  make_room(s);
  int c = s->problem.contacts, least = 0;
  double frame[3][3], axis[3] = {0};
  for (int i = 1; i < 3; i++)
    if (fabs(e[i]) < fabs(e[least])) least = i;
  axis[least] = 1;
  memcpy(frame[0], e, sizeof frame[0]);
  cross(e, axis, frame[1]);
  normalise(frame[1]);
  cross(frame[0], frame[1], frame[2]);
  if (c == 0) s->first[0] = 0;
  s->first[c + 1] = s->first[c];
  if (a != GROUND) add_part(s, a, -1, p, frame);
  add_part(s, b, 1, p, frame);
  double gap = uniform(s, 0, 1) < 0.1 ? uniform(s, 0, 1e-4) : 0;
  for (int d = 0; d < ROWS; d++) s->w[ROWS * c + d] = d == 0 ? gap / step : 0;
  s->problem.contacts++;
}

/* What all contacts of a sample have in common is drawn once. */
static void draw_grip(friction_sample *s)
{
  double alike = pick(s, 6) ? uniform(s, 0, 2) : 0.6;
  for (int c = 0; c < s->problem.contacts; c++)
    s->mu[c] = s->grip == FRICTION_ALIKE   ? alike
               : s->grip == FRICTION_MIXED ? uniform(s, 0, 2)
                                           : pick(s, 2);
}

/* Wall: bricks of 0.2 x 0.1 x 0.1 m in running bond on the ground. */

static void add_corners(friction_sample *s, int below, int above, double from, double to, double z)
{
  const double up[3] = {0, 0, 1};
  for (int k = 0; k < 4; k++) {
    const double p[3] = {k % 2 ? from : to, k / 2 ? -0.05 : 0.05, z};
    add_contact(s, below, above, p, up);
  }
}

/* The upright joint between two bricks of a row. */
static void add_joint(friction_sample *s, int left, int right, double x, double z)
{
  const double along[3] = {1, 0, 0};
  for (int k = 0; k < 4; k++) {
    const double p[3] = {x, k % 2 ? -0.05 : 0.05, z + (k / 2 ? -0.05 : 0.05)};
    add_contact(s, left, right, p, along);
  }
}

static void build_wall(friction_sample *s, int contacts)
{
  const double half[3] = {0.1, 0.05, 0.05};
  int joints = pick(s, 2), each = joints ? 12 : 8;
  int bricks = contacts / each + 1, width = 2 + pick(s, (int)sqrt(3.0 * bricks) + 1);
  for (int i = 0; i * width < bricks; i++)
    for (int j = 0; j < width; j++) {
      double x = 0.2 * j + 0.1 * (i % 2), z = 0.05 + 0.1 * i;
      int own = add_box(s, (const double[]){x, 0, z}, half, 0), row = (i - 1) * width;
      if (i == 0) add_corners(s, GROUND, own, x - 0.1, x + 0.1, 0);
      for (int k = j - 1; i > 0 && k <= j + 1; k++) {
        if (k < 0 || k >= width) continue;
        double other = s->body[row + k].c[0], from = fmax(x, other) - 0.1;
        double to = fmin(x, other) + 0.1;
        if (to - from > 0.01) add_corners(s, row + k, own, from, to, z - 0.05);
      }
      if (joints && j > 0) add_joint(s, own - 1, own, x - 0.1, z);
    }
}

/* Spheres: some on the ground, the others on three that lie near each other. */

static double distance(const double *a, const double *b)
{
  const double d[3] = {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
  return sqrt(dot(d, d));
}

static int is_free(const friction_sample *s, const double *c, double radius)
{
  for (int i = 0; i < s->bodies; i++)
    if (distance(s->body[i].c, c) < s->body[i].radius + radius - 1e-12) return 0;
  return c[2] >= radius;
}

/* The upper centre at the distances r[k] of three points; 0 where there is none. */
static int above(const double *const at[3], const double *r, double *c)
{
  double x[3], y[3], z[3], other[3];
  for (int i = 0; i < 3; i++) {
    x[i] = at[1][i] - at[0][i];
    other[i] = at[2][i] - at[0][i];
  }
  double far = sqrt(dot(x, x));
  normalise(x);
  double along = dot(x, other);
  for (int i = 0; i < 3; i++) y[i] = other[i] - along * x[i];
  double across = sqrt(dot(y, y));
  normalise(y);
  cross(x, y, z);
  double of_x = (r[0] * r[0] - r[1] * r[1] + far * far) / (2 * far);
  double of_y = (r[0] * r[0] - r[2] * r[2] + along * along + across * across - 2 * along * of_x) /
                (2 * across);
  double square = r[0] * r[0] - of_x * of_x - of_y * of_y, up = z[2] > 0 ? 1 : -1;
  if (!(square > 0.01 * r[0] * r[0])) return 0;
  for (int i = 0; i < 3; i++)
    c[i] = at[0][i] + of_x * x[i] + of_y * y[i] + up * sqrt(square) * z[i];
  return 1;
}

static void touch(friction_sample *s, int below, int own)
{
  const friction_body *a = &s->body[below], *b = &s->body[own];
  double e[3], p[3];
  for (int i = 0; i < 3; i++) e[i] = b->c[i] - a->c[i];
  normalise(e);
  for (int i = 0; i < 3; i++) p[i] = a->c[i] + a->radius * e[i];
  add_contact(s, below, own, p, e);
}

static void put_on_ground(friction_sample *s, double width)
{
  double radius = uniform(s, 0.05, 0.08);
  const double c[3] = {uniform(s, 0, width), uniform(s, 0, width), radius};
  if (!is_free(s, c, radius)) return;
  int own = add_sphere(s, c, radius);
  add_contact(s, GROUND, own, (const double[]){c[0], c[1], 0}, (const double[]){0, 0, 1});
}

/* Tries one place; a pile grows at its top, where the last bodies are. */
static void put_on_three(friction_sample *s)
{
  int under[3], last = s->bodies < 60 ? s->bodies : 60;
  const double *at[3];
  double radius = uniform(s, 0.05, 0.08), r[3], c[3];
  for (int k = 0; k < 3; k++) {
    under[k] = s->bodies - 1 - pick(s, last);
    at[k] = s->body[under[k]].c;
    r[k] = s->body[under[k]].radius + radius;
  }
  for (int k = 0; k < 3; k++)
    if (under[k] == under[(k + 1) % 3] || distance(at[k], at[(k + 1) % 3]) > 0.3) return;
  if (!above(at, r, c) || !is_free(s, c, radius)) return;
  double top = fmax(at[0][2], fmax(at[1][2], at[2][2]));
  if (c[2] < top) return;
  int own = add_sphere(s, c, radius);
  for (int k = 0; k < 3; k++) touch(s, under[k], own);
}

static void build_spheres(friction_sample *s, int contacts)
{
  double width = 0.13 * sqrt(contacts / 12.0) + 0.2;
  for (int k = 0; k < 40 * contacts && s->problem.contacts < contacts / 6 + 4; k++)
    put_on_ground(s, width);
  for (long k = 0; k < 4000L * contacts && s->problem.contacts < contacts; k++) put_on_three(s);
}

/* Tower: layers of parallel planks, each layer turned against the one below. */

typedef struct polygon {
  int count;
  double at[12][2];
} polygon;

static polygon outline(const friction_body *b)
{
  polygon p = {.count = 4};
  const double sign[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
  for (int k = 0; k < 4; k++)
    for (int i = 0; i < 2; i++)
      p.at[k][i] = b->c[i] + sign[k][0] * b->half[0] * b->axis[0][i] +
                   sign[k][1] * b->half[1] * b->axis[1][i];
  return p;
}

/* What of a convex polygon lies left of the line from a to b (Sutherland and Hodgman, CACM 17
 * (1974) 32). */
static polygon clip(const polygon *p, const double *a, const double *b)
{
  polygon out = {.count = 0};
  for (int k = 0; k < p->count; k++) {
    const double *from = p->at[k], *to = p->at[(k + 1) % p->count];
    double f = (b[0] - a[0]) * (from[1] - a[1]) - (b[1] - a[1]) * (from[0] - a[0]);
    double t = (b[0] - a[0]) * (to[1] - a[1]) - (b[1] - a[1]) * (to[0] - a[0]);
    if (f >= 0) memcpy(out.at[out.count++], from, sizeof out.at[0]);
    if ((f < 0) == (t < 0)) continue;
    for (int i = 0; i < 2; i++) out.at[out.count][i] = from[i] + f / (f - t) * (to[i] - from[i]);
    out.count++;
  }
  return out;
}

/* The corners of what two faces have in common. */
static void lay_on(friction_sample *s, int below, int own, double z)
{
  polygon common = outline(&s->body[own]), face = outline(&s->body[below]);
  for (int k = 0; k < 4; k++) common = clip(&common, face.at[k], face.at[(k + 1) % 4]);
  for (int k = 0; k < common.count; k++)
    add_contact(s, below, own, (const double[]){common.at[k][0], common.at[k][1], z},
                (const double[]){0, 0, 1});
}

static void build_tower(friction_sample *s, int contacts)
{
  int planks = 2 + pick(s, contacts > 200 ? 4 : 2), before = 0;
  const double half[3] = {0.3, 0.04, 0.03};
  for (int layer = 0; s->problem.contacts < contacts; layer++) {
    double angle = pi / 2 * layer + uniform(s, -0.3, 0.3), z = 0.06 * layer + 0.03;
    int start = s->bodies;
    for (int k = 0; k < planks; k++) {
      double aside = 0.5 * ((k + 0.5) / planks - 0.5) + uniform(s, -0.01, 0.01);
      const double c[3] = {-sin(angle) * aside, cos(angle) * aside, z};
      int own = add_box(s, c, half, angle);
      polygon face = outline(&s->body[own]);
      for (int i = 0; layer == 0 && i < face.count; i++)
        add_contact(s, GROUND, own, (const double[]){face.at[i][0], face.at[i][1], 0},
                    (const double[]){0, 0, 1});
      for (int j = before; layer > 0 && j < start; j++) lay_on(s, j, own, z - 0.03);
    }
    before = start;
  }
}

/* Storeys: slabs on layers of equal spheres. */

static void build_storeys(friction_sample *s, int contacts)
{
  int side = 2 + pick(s, contacts > 200 ? 4 : 2), floor = GROUND;
  double radius = 0.05, z = 0, width = 0.12 * side;
  const double half[3] = {0.5 * width, 0.5 * width, 0.02}, up[3] = {0, 0, 1};
  while (s->problem.contacts < contacts) {
    int start = s->bodies;
    for (int k = 0; k < side * side; k++) {
      double x = 0.12 * (k % side - 0.5 * (side - 1)) + uniform(s, -0.009, 0.009);
      double y = 0.12 * (int)(k / side) - 0.06 * (side - 1) + uniform(s, -0.009, 0.009);
      int own = add_sphere(s, (const double[]){x, y, z + radius}, radius);
      add_contact(s, floor, own, (const double[]){x, y, z}, up);
    }
    z += 2 * radius;
    int slab = add_box(s, (const double[]){0, 0, z + half[2]}, half, 0);
    for (int k = start; k < slab; k++)
      add_contact(s, k, slab, (const double[]){s->body[k].c[0], s->body[k].c[1], z}, up);
    floor = slab;
    z += 2 * half[2];
  }
}

/* M by blocks and f = M v + h m g. */
static void close_sample(friction_sample *s)
{
  double tilt = s->motion == FRICTION_TILTED ? uniform(s, 0.1, 0.8) : 0, turn = uniform(s, 0, 6.28);
  const double g[3] = {gravity * sin(tilt) * cos(turn), gravity * sin(tilt) * sin(turn),
                       -gravity * cos(tilt)};
  size_t n = FREEDOMS * (size_t)s->bodies;
  s->size = grow(s->size, (size_t)s->bodies, sizeof *s->size);
  s->M = grow(s->M, FREEDOMS * n, sizeof *s->M);
  s->f = grow(s->f, n, sizeof *s->f);
  memset(s->M, 0, FREEDOMS * n * sizeof *s->M);
  for (int k = 0; k < s->bodies; k++) {
    const friction_body *b = &s->body[k];
    double *M = s->M + (size_t)k * FREEDOMS * FREEDOMS, *f = s->f + (size_t)k * FREEDOMS,
           v[FREEDOMS];
    s->size[k] = FREEDOMS;
    for (int i = 0; i < FREEDOMS; i++)
      v[i] = s->motion == FRICTION_HIT ? uniform(s, -1, 1) * (i < 3 ? 1 : 3) : 0;
    for (int i = 0; i < 3; i++) {
      M[i * FREEDOMS + i] = b->mass;
      f[i] = b->mass * (v[i] + step * g[i]);
      f[3 + i] = dot(b->inertia[i], v + 3);
      for (int j = 0; j < 3; j++) M[(3 + j) * FREEDOMS + 3 + i] = b->inertia[i][j];
    }
  }
}

void friction_sample_draw(friction_sample *s, int family, int contacts, unsigned long long seed)
{
  static void (*const build[FRICTION_FAMILIES])(friction_sample *, int) = {
      build_wall, build_spheres, build_tower, build_storeys};
  *s = (friction_sample){.family = family, .state = seed * 2862933555777941757ull + 3037000493ull};
  for (int k = 0; k < 4; k++) uniform(s, 0, 1); /* seeds beside each other go apart */
  s->motion = pick(s, FRICTION_MOTIONS);
  s->grip = pick(s, FRICTION_GRIPS);
  s->mass_ratio = pick(s, 2) ? 1 : pow(10, uniform(s, 0, 6));
  build[family](s, contacts);
  draw_grip(s);
  close_sample(s);
  nsdae_friction_problem *p = &s->problem;
  p->form = NSDAE_FRICTION_GLOBAL;
  p->mu = s->mu;
  p->w = s->w;
  p->blocks = s->bodies;
  p->size = s->size;
  p->M = s->M;
  p->f = s->f;
  p->first = s->first;
  p->block = s->block;
  p->value = s->value;
}

void friction_sample_change(friction_sample *s, double by)
{
  int n = 0;
  for (int b = 0; b < s->problem.blocks; b++) n += s->problem.size[b];
  for (int i = 0; i < n; i++) s->f[i] *= 1 + uniform(s, -by, by);
}

void friction_sample_release(friction_sample *s)
{
  free(s->body);
  free(s->first);
  free(s->block);
  free(s->size);
  free(s->mu);
  free(s->w);
  free(s->M);
  free(s->f);
  free(s->value);
  *s = (friction_sample){0};
}

/* The residual, in more digits than the impulses have in two parts, where the compiler has them. */

#if defined(__SIZEOF_FLOAT128__)
__extension__ typedef __float128 wide;
#else
typedef long double wide;
#endif

static wide size_of(wide x)
{
  return x < 0 ? -x : x;
}

static wide larger(wide a, wide b)
{
  return b > a ? b : a;
}

/* sqrt(a^2 + b^2): one step of Newton's method doubles the digits of a root. */
static wide length(wide a, wide b)
{
  wide square = a * a + b * b, root = sqrtl((long double)square);
  return root > 0 ? (root + square / root) / 2 : 0;
}

/* x := M^-1 x of a block, by Gauss without pivoting: M is positive definite. */
static void divide(const double *M, wide *x)
{
  wide a[FREEDOMS][FREEDOMS];
  for (int i = 0; i < FREEDOMS; i++)
    for (int j = 0; j < FREEDOMS; j++) a[i][j] = M[j * FREEDOMS + i];
  for (int k = 0; k < FREEDOMS; k++)
    for (int i = k + 1; i < FREEDOMS; i++) {
      wide factor = a[i][k] / a[k][k];
      for (int j = k; j < FREEDOMS; j++) a[i][j] -= factor * a[k][j];
      x[i] -= factor * x[k];
    }
  for (int k = FREEDOMS - 1; k >= 0; k--) {
    for (int j = k + 1; j < FREEDOMS; j++) x[k] -= a[k][j] * x[j];
    x[k] /= a[k][k];
  }
}

static wide part_of(const double *r, const double *low, int i)
{
  return (wide)r[i] + (low ? (wide)low[i] : 0);
}

/* u = H^T M^-1 (f + H (r + low)) + w; r NULL: zero. */
static void velocities(const friction_sample *s, const double *r, const double *low, wide *v,
                       wide *u)
{
  for (int i = 0; i < FREEDOMS * s->bodies; i++) v[i] = s->f[i];
  for (int c = 0; r && c < s->problem.contacts; c++)
    for (int k = s->first[c]; k < s->first[c + 1]; k++)
      for (int e = 0; e < PART; e++)
        v[FREEDOMS * s->block[k] + e % FREEDOMS] +=
            (wide)s->value[(size_t)k * PART + (size_t)e] * part_of(r, low, ROWS * c + e / FREEDOMS);
  for (int b = 0; b < s->bodies; b++) divide(s->M + b * FREEDOMS * FREEDOMS, v + b * FREEDOMS);
  for (int c = 0; c < s->problem.contacts; c++)
    for (int d = 0; d < ROWS; d++) {
      wide sum = s->w[ROWS * c + d];
      for (int k = s->first[c]; k < s->first[c + 1]; k++)
        for (int i = 0; i < FREEDOMS; i++)
          sum += s->value[(size_t)k * PART + (size_t)(d * FREEDOMS + i)] *
                 v[FREEDOMS * s->block[k] + i];
      u[ROWS * c + d] = sum;
    }
}

/* Mean of the diagonal entries of W of a contact. */
static wide mean_of_W(const friction_sample *s, int c)
{
  wide sum = 0;
  for (int k = s->first[c]; k < s->first[c + 1]; k++)
    for (int d = 0; d < ROWS; d++) {
      const double *h = s->value + (size_t)k * PART + (size_t)(d * FREEDOMS);
      wide x[FREEDOMS];
      for (int i = 0; i < FREEDOMS; i++) x[i] = h[i];
      divide(s->M + s->block[k] * FREEDOMS * FREEDOMS, x);
      for (int i = 0; i < FREEDOMS; i++) sum += h[i] * x[i];
    }
  return sum / ROWS;
}

/* z := its projection on the cone |z_T| <= mu z_N. */
static void project(wide mu, wide *z)
{
  wide size = length(z[1], z[2]);
  if (size <= mu * z[0]) return;
  if (mu * size <= -z[0]) {
    z[0] = z[1] = z[2] = 0;
    return;
  }
  wide normal = (z[0] + mu * size) / (1 + mu * mu);
  for (int i = 1; i < 3; i++) z[i] *= mu * normal / size;
  z[0] = normal;
}

static wide contact_residual(double mu, const double *r, const double *low, const wide *u, wide d,
                             wide scale)
{
  wide x[3], z[3], worst = 0;
  for (int i = 0; i < 3; i++) {
    wide shift = i == 0 ? mu * length(u[1], u[2]) : 0;
    x[i] = part_of(r, low, i) * d / scale;
    z[i] = x[i] - (u[i] + shift) / scale;
  }
  project(mu, z);
  for (int i = 0; i < 3; i++)
    if (!(size_of(x[i] - z[i]) <= worst)) worst = size_of(x[i] - z[i]);
  return worst;
}

double friction_sample_residual(const friction_sample *s, const double *r, const double *low)
{
  size_t rows = ROWS * (size_t)s->problem.contacts, n = FREEDOMS * (size_t)s->bodies;
  wide *v = grow(NULL, n + rows, sizeof *v), *u = v + n, scale = 0, worst = 0;
  velocities(s, NULL, NULL, v, u);
  for (size_t i = 0; i < rows; i++) scale = larger(scale, size_of(u[i]));
  velocities(s, r, low, v, u);
  for (int c = 0; c < s->problem.contacts && worst == worst; c++) {
    wide one = contact_residual(s->mu[c], r + ROWS * c, low ? low + ROWS * c : NULL, u + ROWS * c,
                                mean_of_W(s, c), scale);
    if (!(one <= worst)) worst = one;
  }
  free(v);
  return (double)worst;
}

double friction_sample_largest(const friction_sample *s, const double *r)
{
  size_t rows = ROWS * (size_t)s->problem.contacts, n = FREEDOMS * (size_t)s->bodies;
  wide *v = grow(NULL, n + rows, sizeof *v), *u = v + n, scale = 0, largest = 0;
  velocities(s, NULL, NULL, v, u);
  for (size_t i = 0; i < rows; i++) scale = larger(scale, size_of(u[i]));
  for (size_t i = 0; i < rows; i++)
    largest = larger(largest, size_of(r[i]) * mean_of_W(s, (int)(i / ROWS)) / scale);
  free(v);
  return (double)largest;
}

/* The local form. */

/* H_j^T M^-1 H_i of the bodies that contacts i and j share, added to W [3 x 3], column by column.
 */
static int couple(const friction_sample *s, int j, int i, double *W)
{
  int any = 0;
  for (int k = s->first[i]; k < s->first[i + 1]; k++)
    for (int l = s->first[j]; l < s->first[j + 1]; l++) {
      if (s->block[k] != s->block[l]) continue;
      any = 1;
      for (int d = 0; d < ROWS; d++) {
        wide x[FREEDOMS];
        for (int e = 0; e < FREEDOMS; e++) x[e] = s->value[k * PART + d * FREEDOMS + e];
        divide(s->M + s->block[k] * FREEDOMS * FREEDOMS, x);
        for (int of = 0; of < ROWS; of++)
          for (int e = 0; e < FREEDOMS; e++)
            W[d * ROWS + of] += (double)(s->value[l * PART + of * FREEDOMS + e] * x[e]);
      }
    }
  return any;
}

static void add_item(const friction_sample *s, friction_local *local, int i, int *room)
{
  int *end = &local->first[i + 1];
  *end = local->first[i];
  for (int j = 0; j < s->problem.contacts; j++) {
    double W[ROWS * ROWS] = {0};
    if (!couple(s, j, i, W)) continue;
    if (*end == *room) {
      *room = 2 * *room + 64;
      local->block = grow(local->block, (size_t)*room, sizeof *local->block);
      local->value = grow(local->value, ROWS * ROWS * (size_t)*room, sizeof *local->value);
    }
    local->block[*end] = j;
    memcpy(local->value + (size_t)(*end)++ * ROWS * ROWS, W, sizeof W);
  }
}

void friction_sample_local(const friction_sample *s, friction_local *local)
{
  int contacts = s->problem.contacts, room = 0;
  size_t rows = ROWS * (size_t)contacts, n = FREEDOMS * (size_t)s->bodies;
  *local = (friction_local){.first = grow(NULL, (size_t)contacts + 1, sizeof *local->first),
                            .q = grow(NULL, rows, sizeof *local->q)};
  wide *v = grow(NULL, n + rows, sizeof *v), *u = v + n;
  velocities(s, NULL, NULL, v, u);
  for (size_t i = 0; i < rows; i++) local->q[i] = (double)u[i];
  free(v);
  local->first[0] = 0;
  for (int i = 0; i < contacts; i++) add_item(s, local, i, &room);
  local->problem = (nsdae_friction_problem){.form = NSDAE_FRICTION_LOCAL,
                                            .contacts = contacts,
                                            .mu = s->mu,
                                            .w = local->q,
                                            .first = local->first,
                                            .block = local->block,
                                            .value = local->value};
}

void friction_local_release(friction_local *local)
{
  free(local->first);
  free(local->block);
  free(local->value);
  free(local->q);
  *local = (friction_local){0};
}
