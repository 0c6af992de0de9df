/* Islands against reachability by brute force, on random graphs of contacts, rows and frictional
 * joints, which go with a row. */
#include "check.h"

#include "support/random.h"
#include "contact_islands.h"

enum { BLOCKS = 30, CONTACTS = 40, ROWS = 10, JOINTS = 4 };

typedef struct sample {
  random_state random;
  int pair[2 * CONTACTS], first[ROWS + 1], block[2 * ROWS], contact[CONTACTS];
  int begin[CONTACTS + 1], part[2 * CONTACTS]; /* of the contacts' rows */
  int joint_first[JOINTS + 1], joint_block[JOINTS];
  nsdae_frictional_joint joint[JOINTS];
  int starts[BLOCKS + 1];
  nsdae_system system;
  nsdae_terms terms;
  int reach[BLOCKS][BLOCKS], in[BLOCKS];
  nsdae_contact_islands graph;
} sample;

static void layout(void *object, nsdae_arena *arena)
{
  sample *s = object;
  nsdae_contact_islands_layout(&s->graph, &s->system, arena);
}

static void join(sample *s, int a, int b)
{
  s->in[a] = s->in[b] = 1;
  s->reach[a][b] = s->reach[b][a] = 1;
}

static void draw(sample *s, int contacts)
{
  memset(s->reach, 0, sizeof s->reach);
  memset(s->in, 0, sizeof s->in);
  for (int i = 0; i < contacts; i++) {
    int a = random_int(&s->random, 0, BLOCKS - 1), b = random_int(&s->random, -1, BLOCKS - 1);
    if (a == b) b = -1;
    int swap = random_int(&s->random, 0, 1);
    s->pair[2 * i + swap] = a;
    s->pair[2 * i + 1 - swap] = b;
    join(s, a, b < 0 ? a : b);
  }
  for (int i = 0; i <= ROWS; i++) s->first[i] = 2 * i;
  for (int i = 0; i < ROWS; i++) {
    s->block[2 * i] = random_int(&s->random, 0, BLOCKS - 2);
    s->block[2 * i + 1] = s->block[2 * i] + 1;
    join(s, s->block[2 * i], s->block[2 * i + 1]);
  }
  for (int j = 0; j < JOINTS; j++) { /* one without friction */
    s->joint_block[j] = random_int(&s->random, 0, BLOCKS - 1);
    if (s->joint[j].mu > 0) join(s, s->joint_block[j], s->block[2 * s->joint[j].constraint]);
  }
  for (int i = 0, p = 0; i < contacts; i++) {
    for (int e = 0; e < 2; e++)
      if (s->pair[2 * i + e] >= 0) s->part[p++] = s->pair[2 * i + e];
    s->begin[i + 1] = p;
  }
  for (int k = 0; k < BLOCKS; k++)
    for (int i = 0; i < BLOCKS; i++)
      for (int j = 0; j < BLOCKS; j++) s->reach[i][j] |= s->reach[i][k] && s->reach[k][j];
}

static void expect_islands(const sample *s, int contacts)
{
  const nsdae_contact_islands *g = &s->graph;
  int blocks = 0;
  for (int a = 0; a < BLOCKS; a++) {
    assert_int_equal(g->of[a] >= 0, s->in[a]);
    blocks += s->in[a];
    for (int b = 0; b < BLOCKS; b++)
      if (s->in[a] && s->in[b] && a != b) assert_int_equal(g->of[a] == g->of[b], s->reach[a][b]);
  }
  assert_int_equal(g->block.first[g->count], blocks);
  assert_int_equal(g->contact.first[g->count], contacts);
  assert_int_equal(g->row.first[g->count], ROWS);
  assert_int_equal(g->joint.first[g->count], JOINTS - 1);
  for (int island = 0; island < g->count; island++) {
    assert_true(nsdae_members_count(&g->block, island) > 0);
    for (int i = g->block.first[island]; i < g->block.first[island + 1]; i++) {
      assert_int_equal(g->of[g->block.of[i]], island);
      if (i > g->block.first[island]) assert_true(g->block.of[i] > g->block.of[i - 1]);
    }
    for (int i = g->contact.first[island]; i < g->contact.first[island + 1]; i++) {
      const int *pair = s->pair + 2 * g->contact.of[i];
      assert_int_equal(g->of[pair[0] >= 0 ? pair[0] : pair[1]], island);
    }
    for (int i = g->row.first[island]; i < g->row.first[island + 1]; i++)
      assert_int_equal(g->of[s->block[2 * g->row.of[i]]], island);
    for (int i = g->joint.first[island]; i < g->joint.first[island + 1]; i++)
      assert_int_equal(g->of[s->joint_block[g->joint_number[g->joint.of[i]]]], island);
  }
}

static void test_random_graphs(void **state)
{
  static sample s;
  nsdae_arena arena;
  (void)state;
  s.system.by_list = 1;
  s.system.dims.m = ROWS;
  s.system.dims.f = JOINTS;
  s.system.blocks = (nsdae_blocks){.count = BLOCKS, .first = s.starts};
  s.system.frictional_joint = s.joint;
  for (int j = 0; j < JOINTS; j++) {
    s.joint[j].constraint = 2 * j;
    s.joint[j].mu = j != 1;
    s.joint_first[j + 1] = j + 1;
  }
  s.terms.system = &s.system;
  s.terms.by.normal = (nsdae_rows){.first = s.begin, .block = s.part};
  s.terms.by.jacobian = (nsdae_rows){.count = ROWS, .first = s.first, .block = s.block};
  s.terms.by.frictional_joint = (nsdae_rows){.first = s.joint_first, .block = s.joint_block};
  assert_int_equal(nsdae_arena_build(&arena, layout, &s), 0);
  s.graph.contact.of = s.contact;
  int number[CONTACTS];
  for (int i = 0; i < CONTACTS; i++) number[i] = i;
  for (int round = 0; round < 500; round++) {
    int contacts = random_int(&s.random, 0, CONTACTS);
    draw(&s, contacts);
    nsdae_contact_islands_find(&s.graph, &s.terms, contacts, number);
    expect_islands(&s, contacts);
  }
  nsdae_arena_release(&arena);
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_random_graphs)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
