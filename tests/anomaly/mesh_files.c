/* Mesh files: what an independent writer of OBJ and STL wrote is read to the bit and has the same
 * contacts; hostile files are refused by name; damaged ones, in seeded ways, are refused or are a
 * mesh; lost allocations leave nothing. NSDAE_LONG: number of damaged files of each format. */
#include "check.h"

#include <nsdae/nsdae.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <time.h>

#include "allocator.h"
#include "support/random.h"

enum { SIDE = 6, POINTS = SIDE * SIDE, TRIANGLES = 2 * (SIDE - 1) * (SIDE - 1), FORMATS = 3 };
enum { DAMAGED_DEFAULT = 6000, LENGTH_MAX = 1 << 14 };

static const char *const paths[FORMATS] = {"mesh_files.obj", "mesh_files_text.stl",
                                           "mesh_files_binary.STL"};
static uint64_t seed = 5;

/* A rough surface; points are numbered in the order in which triangles have them. */
typedef struct surface {
  double point[POINTS][3];
  int triangle[TRIANGLES][3];
} surface;

/* single: coordinates of single precision. */
static void make_surface(surface *s, int single)
{
  double x[POINTS][3], unit = exp(random_between(&seed, -8, 8));
  int number[POINTS], count = 0, t = 0;
  for (int i = 0; i < POINTS; i++) {
    number[i] = -1;
    for (int j = 0; j < 3; j++) {
      double at = j == 0 ? i % SIDE : j == 1 ? i / SIDE : 0;
      x[i][j] = unit * (at + random_between(&seed, -0.2, 0.2));
      if (single) x[i][j] = (float)x[i][j];
    }
  }
  for (int i = 0; i < POINTS; i++) {
    if (i % SIDE == SIDE - 1 || i / SIDE == SIDE - 1) continue;
    const int corner[6] = {i, i + 1, i + SIDE + 1, i, i + SIDE + 1, i + SIDE};
    for (int k = 0; k < 6; k++) {
      int p = corner[k];
      if (number[p] < 0) {
        memcpy(s->point[count], x[p], sizeof x[p]);
        number[p] = count++;
      }
      s->triangle[t + k / 3][k % 3] = number[p];
    }
    t += 2;
  }
  assert_int_equal(count, POINTS);
  assert_int_equal(t, TRIANGLES);
}

/* ---- the writers */

/* A corner of a face: with or without numbers of texture and normal, from the first or the last. */
static void write_corner(FILE *f, int p, int known)
{
  static const char *const rest[] = {"", "/1", "//1", "/1/2"};
  fprintf(f, " %d%s", random_below(&seed, 2) ? p + 1 : p - known, rest[random_below(&seed, 4)]);
}

/* Points before the faces, or each before the first that has it; all that is not read is there. */
static void write_obj(FILE *f, const surface *s)
{
  int known = 0, at_once = random_below(&seed, 2);
  fprintf(f, random_below(&seed, 2) ? "\xEF\xBB\xBF" : "# rough\r\n");
  if (at_once) fprintf(f, "mtllib no such file.mtl\no name\nvt 0 0\nvn 0 0 1\n\n");
  for (int t = 0; t < TRIANGLES; t++) {
    for (int k = 0; k < 3; k++) {
      int most = at_once ? POINTS - 1 : s->triangle[t][k];
      for (; known <= most; known++)
        fprintf(f, "  v\t%.17g %.17g  %.17g%s\n", s->point[known][0], s->point[known][1],
                s->point[known][2], random_below(&seed, 2) ? " 1.0" : " # point");
    }
    fprintf(f, random_below(&seed, 3) ? "f" : "s off\nl 1 2\ng part\nf");
    for (int k = 0; k < 3; k++) {
      if (random_below(&seed, 8) == 0) fprintf(f, " \\\n");
      write_corner(f, s->triangle[t][k], known);
    }
    fprintf(f, t == TRIANGLES - 1 ? "" : random_below(&seed, 2) ? "\r\n" : " \n");
  }
}

static void write_stl(FILE *f, const surface *s)
{
  int cut = random_below(&seed, TRIANGLES), upper = random_below(&seed, 2);
  fprintf(f, "\n solid a b c\n");
  for (int t = 0; t < TRIANGLES; t++) {
    if (t == cut) fprintf(f, "endsolid a b c\n\nsolid\n");
    fprintf(f, upper ? "FACET NORMAL nan 0 0\nOUTER LOOP\n" : "facet normal 0 0 1\n outer loop\n");
    for (int k = 0; k < 3; k++) {
      const double *x = s->point[s->triangle[t][k]];
      fprintf(f, "vertex %.17g %.17g %.17g\n", x[0], x[1], x[2]);
    }
    fprintf(f, "endloop endfacet\n");
  }
  fprintf(f, "endsolid a b c");
}

static void write_binary(FILE *f, const surface *s)
{
  unsigned char head[84] = "solid in name alone", count = TRIANGLES;
  head[80] = count;
  fwrite(head, 1, sizeof head, f);
  for (int t = 0; t < TRIANGLES; t++) {
    float x[12] = {0};
    for (int i = 0; i < 9; i++) x[3 + i] = (float)s->point[s->triangle[t][i / 3]][i % 3];
    for (int i = 0; i < 12; i++) {
      uint32_t bits;
      memcpy(&bits, &x[i], sizeof bits);
      for (int shift = 0; shift < 32; shift += 8) putc((int)(bits >> shift & 255), f);
    }
    fputs("\1\2", f);
  }
}

/* A new file: the old one is not cut to length 0, which some file systems write to the disk. */
static FILE *open_new(const char *path)
{
  remove(path);
  FILE *f = fopen(path, "wb");
  assert_non_null(f);
  return f;
}

static void write_format(int format, const surface *s)
{
  static void (*const writers[FORMATS])(FILE *, const surface *) = {write_obj, write_stl,
                                                                    write_binary};
  FILE *f = open_new(paths[format]);
  writers[format](f, s);
  fclose(f);
}

/* ---- what is written is read */

/* Balls that fall on the surface: their coordinates at the end; the steps with contacts. */
static int drop_on(const nsdae_solid *ground, double unit, double q[14])
{
  nsdae_bodies *b;
  nsdae_system *system;
  nsdae_sim *sim;
  nsdae_sim_options o;
  nsdae_record r;
  double v[12];
  assert_int_equal(nsdae_bodies_create(3, &b, NULL), NSDAE_OK);
  nsdae_bodies_set_gravity(b, (const double[]){0, 0, -10 * unit});
  nsdae_bodies_set_pair(b, 0, 0, 0.3, 0, 0);
  assert_int_equal(nsdae_bodies_add_solid(b, NSDAE_GROUND, ground), 0);
  for (int i = 0; i < 2; i++) {
    const nsdae_solid ball = {.shape = NSDAE_SHAPE_SPHERE, .radius = 0.4 * unit};
    nsdae_rigid_body body = {.mass = 1, .position = {(1.5 + i) * unit, 2 * unit, 0.8 * unit}};
    for (int j = 0; j < 3; j++) body.inertia[j] = 0.1 * unit * unit;
    nsdae_bodies_add_solid(b, nsdae_bodies_add(b, &body), &ball);
  }
  assert_true(nsdae_bodies_system(b, &system) >= 0);
  nsdae_sim_options_default(&o);
  o.method = NSDAE_METHOD_MOREAU;
  o.dt = 0.01;
  o.start_tol = 1; /* the balls may begin deep in the ground */
  assert_int_equal(nsdae_sim_create(system, &o, &sim, NULL), NSDAE_OK);
  nsdae_bodies_get_start(b, q, v);
  if (nsdae_sim_init(sim, 0, q, v) != NSDAE_OK) fail_msg("%s", nsdae_sim_error(sim)->text);
  int met = 0;
  for (int i = 0; i < 40; i++) {
    assert_true(nsdae_sim_step(sim) >= 0);
    nsdae_sim_get_record(sim, &r);
    met += r.contacts.count > 0;
  }
  memcpy(q, r.q, 14 * sizeof *q);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  nsdae_bodies_destroy(&b);
  return met;
}

static void test_written(void **state)
{
  (void)state;
  for (int i = 0; i < 60; i++) {
    int format = i % FORMATS;
    double scale = i % 2 ? 0.001 : 1, q[2][14];
    surface s;
    nsdae_solid read;
    nsdae_error error;
    make_surface(&s, format == 2);
    write_format(format, &s);
    int status = nsdae_solid_read(paths[format], scale, &read, &error);
    if (status < 0) fail_msg("%s", error.text);
    for (int j = 0; j < 3 * POINTS; j++) (&s.point[0][0])[j] *= scale;
    assert_int_equal(read.shape, NSDAE_SHAPE_MESH);
    assert_int_equal(read.points, POINTS);
    assert_int_equal(read.triangles, TRIANGLES);
    assert_memory_equal(read.point, s.point, sizeof s.point);
    assert_memory_equal(read.triangle, s.triangle, sizeof s.triangle);
    double unit = fabs(s.point[1][0] - s.point[0][0]);
    read.length[2] = unit;
    nsdae_solid given = {.shape = NSDAE_SHAPE_MESH, .length = {0, 0, unit}};
    given.points = POINTS;
    given.point = &s.point[0][0];
    given.triangles = TRIANGLES;
    given.triangle = &s.triangle[0][0];
    assert_true(drop_on(&read, unit, q[0]) > 5);
    drop_on(&given, unit, q[1]);
    assert_memory_equal(q[0], q[1], sizeof q[0]);
    nsdae_solid_release(&read);
    assert_null(read.point);
  }
}

/* Triangles of a file left out, twice and in clockwise order: sides of one and of many triangles.
 * Balls stay finite; those that meet a triangle are stopped or pass through it. */
static void test_topology(void **state)
{
  (void)state;
  for (int i = 0; i < 30; i++) {
    surface s;
    nsdae_solid read;
    double q[14];
    make_surface(&s, 1);
    for (int t = 0; t < TRIANGLES; t++) {
      int kind = random_below(&seed, 6), other = random_below(&seed, TRIANGLES);
      if (kind == 0) memcpy(s.triangle[t], s.triangle[other], sizeof s.triangle[t]);
      if (kind > 1) continue;
      int corner = s.triangle[t][0];
      s.triangle[t][0] = s.triangle[t][1];
      s.triangle[t][1] = corner;
    }
    write_format(i % FORMATS, &s);
    assert_int_equal(nsdae_solid_read(paths[i % FORMATS], 1, &read, NULL), NSDAE_OK);
    assert_int_equal(read.triangles, TRIANGLES);
    double unit = fabs(s.point[1][0] - s.point[0][0]);
    read.length[2] = unit;
    drop_on(&read, unit, q);
    for (int j = 0; j < 14; j++) assert_true(isfinite(q[j]));
    nsdae_solid_release(&read);
  }
}

/* A block of 2 x 1 x 3 by faces of four corners: moments of its surface, and its hull. */
static void test_block(void **state)
{
  static const char text[] =
      "v 0 0 0\nv 2 0 0\nv 0 1 0\nv 2 1 0\nv 0 0 3\nv 2 0 3\nv 0 1 3\nv 2 1 3\nv 9 9 9\n"
      "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
  const double density = 0.5;
  (void)state;
  FILE *f = open_new(paths[0]);
  fputs(text, f);
  fclose(f);
  for (int hull = 0; hull < 2; hull++) {
    nsdae_solid s;
    nsdae_rigid_body body = {.mass = 0};
    assert_int_equal(nsdae_solid_read(paths[0], 1, &s, NULL), NSDAE_OK);
    assert_int_equal(s.points, 8); /* that of no triangle is left out */
    assert_int_equal(s.triangles, 12);
    s.length[2] = 1;
    if (hull) {
      s.shape = NSDAE_SHAPE_POLYHEDRON;
      s.length[2] = s.triangles = 0;
    }
    assert_int_equal(nsdae_body_from_solids(1, &s, &density, &body, NULL), NSDAE_OK);
    const double exact[4] = {3, 3 * 10 / 12.0, 3 * 13 / 12.0, 3 * 5 / 12.0};
    const double found[4] = {body.mass, body.inertia[0], body.inertia[1], body.inertia[2]};
    for (int i = 0; i < 4; i++) assert_true(fabs(found[i] - exact[i]) < 1e-14 * exact[i]);
    nsdae_solid_release(&s);
  }
}

/* ---- hostile files */

typedef struct hostile {
  int format, status;
  const char *text, *words; /* of the file; of the error */
} hostile;

#define FACET(a, b, c) \
  "facet normal 0 0 0 outer loop vertex " a " vertex " b " vertex " c " endloop endfacet\n"

static const hostile cases[] = {
    {0, NSDAE_E_ARGUMENT, "", "'mesh_files.obj': the file has no triangles"},
    {0, NSDAE_E_ARGUMENT, "v 0 0 0\n", "has no triangles"},
    {0, NSDAE_E_ARGUMENT, "v 0 0\n", "line 1: '' instead of a coordinate"},
    {0, NSDAE_E_ARGUMENT, "v 0 0 x1\n", "line 1: 'x1' instead of a coordinate"},
    {0, NSDAE_E_ARGUMENT,
     "v 0 0 1000000000000000000000000000000000000000000000000000000000000000\n",
     "instead of a coordinate"},
    {0, NSDAE_E_NONFINITE, "\nv 0 nan 0\n", "line 2: point 0 is at 0.5 x nan"},
    {0, NSDAE_E_NONFINITE, "v 0 0 -inf\n", "is at 0.5 x -inf"},
    {0, NSDAE_E_NONFINITE, "v 0 0 1e999\n", "is at 0.5 x inf"},
    {0, NSDAE_E_ARGUMENT, "v 0 0 1e300\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "squares overflow"},
    {0, NSDAE_E_ARGUMENT, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n",
     "line 4: corner '4' of a face: there are 3 points so far, 1 .. 3 or -1 .. -3"},
    {0, NSDAE_E_ARGUMENT, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 0\n", "corner '0'"},
    {0, NSDAE_E_ARGUMENT, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 -4\n", "corner '-4'"},
    {0, NSDAE_E_ARGUMENT, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 99999999999999999999\n", "corner '999"},
    {0, NSDAE_E_ARGUMENT, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3x\n", "corner '3x'"},
    {0, NSDAE_E_ARGUMENT, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2\n", "line 4: a face of 2 corners"},
    {0, NSDAE_E_ARGUMENT, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 2\n",
     "triangle 0 (points 0, 1, 1) has no area"},
    {0, NSDAE_E_ARGUMENT, "v 0 0 0\nv 1 1 0\nv 2 2 0\nf 1 2 3\n", "has no area"},
    {0, NSDAE_E_ARGUMENT, "v 0 0 0\nv 4 0 0\nv 1 1 0\nv 0 4 0\nf 2 3 4 1\n",
     "line 5: a face of 4 corners is not convex"},
    {1, NSDAE_E_ARGUMENT, "", "0 bytes are no STL file"},
    {1, NSDAE_E_ARGUMENT, "solid", "ends before 'endsolid'"},
    {1, NSDAE_E_ARGUMENT, "solid a\nendsolid a\n", "has no triangles"},
    {1, NSDAE_E_ARGUMENT, "solid a\nfacet normal\n", "line 3: '' instead of 'outer' in triangle 0"},
    {1, NSDAE_E_ARGUMENT, "solid a\n" FACET("0 0 0", "1 0 0", "0 1 0"), "ends before 'endsolid'"},
    {1, NSDAE_E_ARGUMENT, "solid a\n" FACET("0 0 0", "1 0 0", "0 1 b") "endsolid",
     "line 2: 'b' instead of a coordinate"},
    {1, NSDAE_E_NONFINITE, "solid a\n" FACET("0 0 0", "1 0 0", "0 1 NaN") "endsolid", "x nan"},
    {1, NSDAE_E_ARGUMENT,
     "solid a\n" FACET("0 0 0", "1 0 0", "0 1 0") FACET("0 0 0", "1 0 0", "1 0 0") "endsolid",
     "triangle 1 (points 0, 1, 1) has no area"},
    {1, NSDAE_E_ARGUMENT, "solid a\nendsolid a\nvertex\n", "line 3: 'vertex' instead of 'solid'"},
};

static void refuse(const char *path, double scale, int status, const char *words)
{
  nsdae_solid solid = {.points = 1};
  nsdae_error error;
  assert_int_equal(nsdae_solid_read(path, scale, &solid, &error), status);
  if (!strstr(error.text, words)) fail_msg("%s\nlacks: %s", error.text, words);
  assert_true(!solid.point && !solid.triangle && !solid.points && !solid.triangles);
  assert_int_equal(solid.shape, NSDAE_SHAPE_MESH);
}

static void test_refused(void **state)
{
  (void)state;
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    FILE *f = open_new(paths[cases[i].format]);
    fputs(cases[i].text, f);
    fclose(f);
    refuse(paths[cases[i].format], 0.5, cases[i].status, cases[i].words);
  }
  refuse("no_such.obj", 1, NSDAE_E_IO, "'no_such.obj': cannot read it: is there such a file?");
  mkdir("mesh_files_folder.obj", 0700);
  refuse("mesh_files_folder.obj", 1, NSDAE_E_IO, "cannot read it: it must be a regular file");
  mkdir("mesh_files_folder.stl", 0700);
  refuse("mesh_files_folder.stl", 1, NSDAE_E_IO, "cannot read it: it must be a regular file");
  refuse("mesh.ply", 1, NSDAE_E_ARGUMENT, "must end in .obj or .stl");
  refuse(NULL, 1, NSDAE_E_ARGUMENT, "path is NULL");
  assert_int_equal(nsdae_solid_read("a.obj", 1, NULL, NULL), NSDAE_E_ARGUMENT);
  const double scales[] = {0, -1, INFINITY, NAN};
  for (int i = 0; i < 4; i++) refuse("a.obj", scales[i], NSDAE_E_ARGUMENT, "0.001 for millimetres");
  nsdae_solid_release(NULL);
}

/* Counts that the length of the file does not have, and files cut off anywhere. */
static void test_cut(void **state)
{
  static unsigned char byte[LENGTH_MAX];
  static const uint32_t counts[] = {
      0, 49, 51, 85899346 /* 50 n overflows 32 bits */, 4000000000u, UINT32_MAX};
  surface s;
  (void)state;
  make_surface(&s, 1);
  write_format(2, &s);
  FILE *f = fopen(paths[2], "rb");
  size_t length = fread(byte, 1, sizeof byte, f);
  fclose(f);
  for (size_t i = 0; i < sizeof counts / sizeof *counts + length; i++) {
    size_t left = i < length ? i : length;
    for (int k = 0; k < 4 && i >= length; k++)
      byte[80 + k] = (unsigned char)(counts[i - length] >> 8 * k);
    byte[0] = (unsigned char)(i % 2 ? 'S' : 'x'); /* begins with solid or not */
    f = open_new(paths[2]);
    fwrite(byte, 1, left, f);
    fclose(f);
    nsdae_solid solid;
    nsdae_error error;
    assert_int_equal(nsdae_solid_read(paths[2], 1, &solid, &error), NSDAE_E_ARGUMENT);
    assert_non_null(strstr(error.text, paths[2]));
    if (byte[0] == 'x') assert_non_null(strstr(error.text, "a binary one of"));
  }
}

/* ---- damaged files */

/* Bytes and bits changed, a stretch cut out or copied, a word of the formats put in, the end lost.
 */
static int damage(char *byte, int length)
{
  static const char *const words[] = {"f ",
                                      "v ",
                                      "-1",
                                      "//",
                                      "nan",
                                      "inf",
                                      "99999999999",
                                      "\n",
                                      "\\\n",
                                      "solid ",
                                      "facet normal ",
                                      "vertex ",
                                      "endsolid",
                                      "endloop",
                                      "\xff\xfe",
                                      "\xef\xbb\xbf",
                                      "#",
                                      "e308",
                                      "0",
                                      "1e-320"};
  for (int times = 1 + random_below(&seed, 4); times > 0 && length > 0; times--) {
    int at = random_below(&seed, length), kind = random_below(&seed, 6), n = 0;
    char piece[64] = "";
    if (kind == 0) byte[at] = (char)random_below(&seed, 256);
    if (kind == 1) byte[at] ^= (char)(1 << random_below(&seed, 8));
    if (kind == 2 && random_below(&seed, 4) == 0) length = at;
    if (kind == 3) {
      n = random_below(&seed, 100) % (length - at);
      memmove(byte + at, byte + at + n, (size_t)(length - at - n));
      length -= n;
    }
    if (kind < 4) continue;
    if (kind == 4) {
      strcpy(piece, words[random_below(&seed, sizeof words / sizeof *words)]);
      n = (int)strlen(piece);
    } else {
      int from = random_below(&seed, length);
      n = random_below(&seed, sizeof piece) % (length - from);
      memcpy(piece, byte + from, (size_t)n);
    }
    if (length + n > LENGTH_MAX) continue;
    memmove(byte + at + n, byte + at, (size_t)(length - at));
    memcpy(byte + at, piece, (size_t)n);
    length += n;
  }
  return length;
}

/* A mesh is one that the ground takes. */
static void check_mesh(nsdae_solid *solid)
{
  nsdae_bodies *b;
  assert_true(solid->points >= 3 && solid->triangles >= 1);
  for (int i = 0; i < 3 * solid->points; i++) assert_true(isfinite(solid->point[i]));
  for (int i = 0; i < 3 * solid->triangles; i++)
    assert_true(solid->triangle[i] >= 0 && solid->triangle[i] < solid->points);
  solid->length[2] = 1;
  assert_int_equal(nsdae_bodies_create(3, &b, NULL), NSDAE_OK);
  assert_int_equal(nsdae_bodies_add_solid(b, NSDAE_GROUND, solid), 0);
  nsdae_bodies_destroy(&b);
}

static void test_damaged(void **state)
{
  static char good[LENGTH_MAX], bad[LENGTH_MAX];
  const char *asked = getenv("NSDAE_LONG");
  long files = asked ? atol(asked) : share_of(DAMAGED_DEFAULT);
  (void)state;
  for (int format = 0; format < FORMATS; format++) {
    long read = 0, refused = 0;
    size_t length = 0;
    for (long i = 0; i < files; i++) {
      if (i % 1000 == 0) {
        surface s;
        make_surface(&s, 1);
        write_format(format, &s);
        FILE *f = fopen(paths[format], "rb");
        length = fread(good, 1, sizeof good, f);
        fclose(f);
      }
      memcpy(bad, good, length);
      FILE *f = open_new(paths[format]);
      size_t left = (size_t)damage(bad, (int)length);
      assert_int_equal(fwrite(bad, 1, left, f), left);
      fclose(f);
      nsdae_solid solid;
      nsdae_error error;
      int status = nsdae_solid_read(paths[format], 1, &solid, &error);
      if (status == NSDAE_OK) {
        check_mesh(&solid);
        read++;
      } else {
        assert_true(status == NSDAE_E_ARGUMENT || status == NSDAE_E_NONFINITE);
        assert_non_null(strstr(error.text, paths[format]));
        assert_true(!solid.point && !solid.triangle);
        refused++;
      }
      nsdae_solid_release(&solid);
    }
    print_message("%s: %ld damaged files read, %ld refused\n", paths[format], read, refused);
    assert_true(refused > files / 10);
  }
}

/* ---- memory */

static void test_memory(void **state)
{
  (void)state;
  for (int format = 0; format < FORMATS; format++) {
    surface s;
    long at = 0;
    make_surface(&s, 1);
    write_format(format, &s);
    for (int met = 1; met; at++) {
      nsdae_solid solid;
      allocator_reset(at);
      int status = nsdae_solid_read(paths[format], 1, &solid, NULL);
      met = the_allocator.calls > at;
      assert_int_equal(status, met ? NSDAE_E_MEMORY : NSDAE_OK);
      nsdae_solid_release(&solid);
      assert_int_equal(the_allocator.live, 0);
    }
    allocator_reset(-1);
    assert_true(at > 15);
  }
}

/* Triangle t of a strip of squares: its corner k. */
static void strip_corner(int t, int k, float x[3])
{
  x[0] = (float)(t / 2 + (t % 2 == 0 ? k == 1 : k < 2));
  x[1] = (float)(t % 2 == 0 ? k == 2 : k > 0);
  x[2] = 0;
}

static void write_strip(int format, int count)
{
  FILE *f = open_new(paths[format]);
  unsigned char head[84] = {0};
  for (int k = 0; k < 4; k++) head[80 + k] = (unsigned char)(count >> 8 * k);
  if (format == 1) fputs("solid\n", f);
  if (format == 2) fwrite(head, 1, sizeof head, f);
  for (int t = 0; t < count; t++) {
    unsigned char byte[50] = {0};
    if (format == 1) fputs("facet normal 0 0 1\nouter loop\n", f);
    for (int k = 0; k < 3; k++) {
      float x[3];
      strip_corner(t, k, x);
      if (format == 0) fprintf(f, "v %g %g %g\n", x[0], x[1], x[2]);
      if (format == 1) fprintf(f, "vertex %g %g %g\n", x[0], x[1], x[2]);
      for (int j = 0; j < 3; j++) {
        uint32_t bits;
        memcpy(&bits, &x[j], sizeof bits);
        for (int i = 0; i < 4; i++) byte[12 + 12 * k + 4 * j + i] = (unsigned char)(bits >> 8 * i);
      }
    }
    if (format == 0) fputs("f -3 -2 -1\n", f);
    if (format == 1) fputs("endloop\nendfacet\n", f);
    if (format == 2) fwrite(byte, 1, sizeof byte, f);
  }
  if (format == 1) fputs("endsolid\n", f);
  fclose(f);
}

/* A million triangles of a binary file, of all formats in the long form. */
static void test_million(void **state)
{
  enum { COUNT = 1000000 };
  (void)state;
  for (int format = getenv("NSDAE_LONG") ? 0 : 2; format < FORMATS; format++) {
    struct rusage use;
    nsdae_solid solid;
    nsdae_error error;
    write_strip(format, COUNT);
    clock_t begin = clock();
    int status = nsdae_solid_read(paths[format], 1, &solid, &error);
    double seconds = (double)(clock() - begin) / CLOCKS_PER_SEC;
    if (status < 0) fail_msg("%s", error.text);
    assert_int_equal(solid.triangles, COUNT);
    assert_int_equal(solid.points, COUNT + 2);
    nsdae_solid_release(&solid);
    getrusage(RUSAGE_SELF, &use);
    print_message("10^6 triangles of %s: %.1f s, at most %ld MB\n", paths[format], seconds,
                  use.ru_maxrss / 1000);
    remove(paths[format]);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_written), cmocka_unit_test(test_topology),
      cmocka_unit_test(test_block),   cmocka_unit_test(test_refused),
      cmocka_unit_test(test_cut),     cmocka_unit_test(test_damaged),
      cmocka_unit_test(test_memory),  cmocka_unit_test(test_million)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
