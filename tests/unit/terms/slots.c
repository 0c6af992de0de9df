/* Terms of contacts by slot, from a list, against those of the same system with fixed contacts:
 * slots in any order, some of them without a contact. */
#include "listed.h"
#include "check.h"

#include <float.h>

#include "as_list.h"
#include "random_system.h"

enum { SLOTS = RANDOM_K + 2 };

typedef struct fixture {
  random_system data;
  nsdae_system *fixed, list; /* list: a copy, with slots */
  as_list *as_list;
  nsdae_tracked tracked;
  long id[SLOTS];
  int used[SLOTS], block[2 * SLOTS], order[SLOTS];
  nsdae_differences differences[2];
  nsdae_terms terms[2]; /* fixed, by list */
  nsdae_error error;
  nsdae_evals evals;
  nsdae_arena arena;
} fixture;

static void layout(void *object, nsdae_arena *arena)
{
  fixture *f = object;
  for (int i = 0; i < 2; i++) {
    nsdae_differences_layout(&f->differences[i], arena);
    nsdae_terms_layout(&f->terms[i], arena);
  }
}

/* A random system with contacts; without what `left_out` says. 0: the seed has none. */
static int begin(fixture *f, uint64_t seed, unsigned left_out)
{
  memset(f, 0, sizeof *f);
  random_system_draw(&f->data, seed, RANDOM_PLAIN);
  f->data.given |= 1u << RANDOM_NORMAL | 1u << RANDOM_CONTACT_BIAS | 1u << RANDOM_ACCELERATION;
  f->data.given &= ~left_out;
  if (f->data.dims.k == 0 || f->data.dims.f > 0) return 0;
  f->fixed = random_system_make(&f->data);
  f->as_list = as_list_create(f->fixed, 1, &f->data.dims.nq, &f->data.dims.nv);
  assert_non_null(f->as_list);
  f->list = *as_list_system(f->as_list);
  f->list.by_list = 0;
  f->list.dims.k = SLOTS;
  f->tracked = (nsdae_tracked){
      .id = f->id, .used = f->used, .block = f->block, .order = f->order, .reach = 1e3};
  f->list.tracked = &f->tracked;
  for (int i = 0; i < 2; i++) {
    f->differences[i].system = f->terms[i].system = i ? &f->list : f->fixed;
    f->terms[i].differences = &f->differences[i];
    f->terms[i].error = &f->error;
    f->terms[i].evals = &f->evals;
  }
  assert_int_equal(nsdae_arena_build(&f->arena, layout, f), NSDAE_OK);
  const nsdae_room contacts = {RANDOM_K, RANDOM_K * 2 * RANDOM_NQ * 3}, rows = {100, 1000};
  assert_int_equal(nsdae_terms_grow(&f->terms[1], &contacts, &rows), NSDAE_OK);
  for (int i = 0; i < 2; i++) nsdae_terms_at(&f->terms[i], 0.3, f->data.q0, f->data.v0);
  return 1;
}

static void end(fixture *f)
{
  if (!f->fixed) return;
  for (int i = 0; i < 2; i++) nsdae_terms_release(&f->terms[i]);
  nsdae_arena_release(&f->arena);
  as_list_destroy(f->as_list);
  nsdae_system_destroy(&f->fixed);
}

/* The contacts in random slots. */
static void put_into_slots(fixture *f, int count, uint64_t *random)
{
  memset(f->used, 0, sizeof f->used);
  for (int i = 0; i < count; i++) {
    int slot = (int)(random_uniform(random) * SLOTS);
    while (f->used[slot]) slot = (slot + 1) % SLOTS;
    f->used[slot] = 1;
    f->block[2 * slot] = 0;
    f->block[2 * slot + 1] = -1;
    f->id[slot] = i;
  }
  nsdae_terms_forget_slots(&f->terms[1]);
}

enum {
  ALL = NSDAE_TERM_GAP | NSDAE_TERM_NORMAL | NSDAE_TERM_TANGENT | NSDAE_TERM_BIAS |
        NSDAE_TERM_ACCELERATION
};

static void near(double a, double b, double tol)
{
  assert_true(fabs(a - b) <= tol * (1 + fabs(b)));
}

/* Gaps, w and the rates along the velocity are equal, of an empty slot none; omega within tol. */
static void compare(fixture *f, double tol)
{
  const nsdae_terms *fixed = &f->terms[0], *T = &f->terms[1];
  int nt = f->data.dims.nt;
  for (int i = 0; i < 2; i++) assert_int_equal(nsdae_terms_need(&f->terms[i], ALL), NSDAE_OK);
  for (int slot = 0; slot < SLOTS; slot++) {
    int used = f->used[slot], i = (int)f->id[slot];
    assert_true(T->gap[slot] == (used ? fixed->gap[i] : NSDAE_FAR));
    near(T->w_N[slot], used ? fixed->w_N[i] : 0, 0);
    near(T->omega.N[slot], used ? fixed->omega.N[i] : 0, tol);
    near(nsdae_terms_normal_rate(T, slot, T->v), used ? nsdae_terms_normal_rate(fixed, i, T->v) : 0,
         4 * DBL_EPSILON);
    for (int j = 0; j < nt; j++) {
      near(T->w_T[slot * nt + j], used ? fixed->w_T[i * nt + j] : 0, 0);
      near(T->omega.T[slot * nt + j], used ? fixed->omega.T[i * nt + j] : 0, tol);
      near(nsdae_terms_tangent_rate(T, slot * nt + j, T->v),
           used ? nsdae_terms_tangent_rate(fixed, i * nt + j, T->v) : 0, 4 * DBL_EPSILON);
    }
  }
}

/* omega given, and by differences: those of the fixed system have the same step, and rounding over
 * it of 2e-13 or so. */
static void compare_family(unsigned left_out, double tol)
{
  int many = 0;
  for (uint64_t seed = 1; seed <= 200; seed++) {
    fixture f;
    uint64_t random = seed;
    if (begin(&f, seed, left_out)) {
      int k = f.data.dims.k;
      for (int count = k; count >= 0; count -= k > 1 ? k - 1 : 1) {
        put_into_slots(&f, count, &random);
        compare(&f, tol);
        f.data.v0[0] += 1;
        for (int i = 0; i < 2; i++) nsdae_terms_set_velocity(&f.terms[i], f.data.v0);
        compare(&f, tol); /* of another velocity at the same point */
      }
      many++;
    }
    end(&f);
  }
  assert_true(many > 40);
}

static void test_given(void **state)
{
  (void)state;
  compare_family(0, 0);
}

static void test_by_differences(void **state)
{
  (void)state;
  compare_family(1u << RANDOM_ACCELERATION, 1e-10);
}

/* A contact that the list has no more is far away; the next one in its slot has its own id. */
static void test_hidden(void **state)
{
  (void)state;
  fixture f;
  uint64_t seed = 0, random = 7;
  char called[NSDAE_CALLED_SIZE];
  while (!begin(&f, ++seed, 0) || f.data.dims.k < 2) end(&f);
  put_into_slots(&f, 2, &random);
  as_list_hide(f.as_list, 1);
  assert_int_equal(nsdae_terms_need(&f.terms[1], ALL), NSDAE_OK);
  for (int slot = 0; slot < SLOTS; slot++) {
    int there = f.used[slot] && f.id[slot] == 0;
    assert_int_equal(f.terms[1].gap[slot] < NSDAE_FAR, there);
    if (!f.used[slot]) continue;
    nsdae_system_called(&f.list, NSDAE_NAME_CONTACT, slot, called);
    assert_string_equal(called, there ? "contact of id 0" : "contact of id 1");
    nsdae_system_name_item(&f.list, NSDAE_NAME_CONTACT, slot, &f.error);
    assert_int_equal(f.error.index, !there);
  }
  end(&f);
}

/* A list that is too long for its room is reported, at the point and where it is differenced. */
static void test_room(void **state)
{
  (void)state;
  fixture f;
  uint64_t seed = 0, random = 7;
  while (!begin(&f, ++seed, 1u << RANDOM_ACCELERATION) || f.data.dims.k < 2) end(&f);
  put_into_slots(&f, 1, &random);
  f.differences[1].by_id.list.room.entries = 0;
  assert_int_equal(nsdae_terms_need(&f.terms[1], ALL), NSDAE_ARRAYS_GROW);
  const nsdae_room contacts = {RANDOM_K, RANDOM_K * 2 * RANDOM_NQ * 3}, rows = {100, 1000};
  assert_int_equal(nsdae_terms_grow(&f.terms[1], &contacts, &rows), NSDAE_OK);
  compare(&f, 1e-10);
  nsdae_terms_at(&f.terms[1], 0.3, f.data.q0, f.data.v0);
  f.terms[1].by.list.room.entries = 0;
  assert_int_equal(nsdae_terms_need(&f.terms[1], ALL), NSDAE_ARRAYS_GROW);
  assert_int_equal(nsdae_terms_grow(&f.terms[1], &contacts, &rows), NSDAE_OK);
  compare(&f, 1e-10);
  end(&f);
}

/* nsdae_system_check compares a given omega with differences. */
static void test_checked(void **state)
{
  (void)state;
  fixture f;
  uint64_t seed = 0;
  nsdae_check worst;
  while (!begin(&f, ++seed, 0) || f.data.dims.k < 1) end(&f);
  nsdae_system *s = as_list_system(f.as_list);
  as_list_list_all(f.as_list, 1);
  assert_int_equal(nsdae_system_check(s, 0.3, f.data.q0, f.data.v0, 1e-5, &worst), NSDAE_OK);
  f.data.fault = (random_fault){.term = RANDOM_ACCELERATION, .for_ever = 1, .value = 1e3};
  assert_int_equal(nsdae_system_check(s, 0.3, f.data.q0, f.data.v0, 1e-5, &worst),
                   NSDAE_E_DERIVATIVE);
  assert_string_equal(worst.term, "contacts");
  assert_true(worst.given == 1e3);
  end(&f);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_given),   cmocka_unit_test(test_by_differences),
      cmocka_unit_test(test_hidden),  cmocka_unit_test(test_room),
      cmocka_unit_test(test_checked),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
