#include "contact_islands.h"

#include <string.h>

#include "disjoint_sets.h"
#include "listed.h"

void nsdae_contact_islands_layout(nsdae_contact_islands *is, const nsdae_system *system,
                                  nsdae_arena *arena)
{
  long blocks = system->blocks.count;
  is->blocks = (int)blocks;
  is->rows = system->dims.m;
  is->joints = 0;
  for (int j = 0; j < system->dims.f; j++) is->joints += nsdae_system_joint_rubs(system, j);
  nsdae_arena_ints(arena, blocks, (int **[]){&is->of, &is->parent, &is->block.of, NULL});
  nsdae_arena_ints(
      arena, blocks + 2,
      (int **[]){&is->block.first, &is->contact.first, &is->row.first, &is->joint.first, NULL});
  is->row.of = NSDAE_ARENA_INTS(arena, is->rows);
  nsdae_arena_ints(arena, is->joints, (int **[]){&is->joint.of, &is->joint_number, NULL});
  if (!is->of) return; /* measuring */
  is->block.first[1] = 1;
  is->row.first[1] = is->rows;
  is->joint.first[1] = is->joints;
  for (int i = 0; i < is->rows; i++) is->row.of[i] = i;
  for (int j = 0, count = 0; j < system->dims.f; j++) {
    if (!nsdae_system_joint_rubs(system, j)) continue;
    is->joint.of[count] = count;
    is->joint_number[count++] = j;
  }
}

/* ---- blocks that are joined */

/* -1: in no set yet. */
static void join(int *parent, int a, int b)
{
  if (parent[a] < 0) parent[a] = a;
  if (parent[b] < 0) parent[b] = b;
  nsdae_sets_join(parent, a, b);
}

/* The first block of row i, which is the first of all where it touches none: that of no motion. */
static int first_block(const nsdae_rows *rows, int i)
{
  return rows->first[i] < rows->first[i + 1] ? rows->block[rows->first[i]] : 0;
}

static void join_row(int *parent, const nsdae_rows *rows, int i, int anchor)
{
  join(parent, anchor, anchor);
  for (int p = rows->first[i]; p < rows->first[i + 1]; p++) join(parent, anchor, rows->block[p]);
}

static int block_of_contact(const nsdae_terms *T, int i)
{
  return first_block(&T->by.normal, i);
}

/* Of the constraint whose load it has, or of its own row. */
static int block_of_joint(const nsdae_terms *T, const nsdae_contact_islands *is, int i)
{
  int j = is->joint_number[i];
  const nsdae_frictional_joint *joint = &T->system->frictional_joint[j];
  return joint->mu > 0 ? first_block(&T->by.jacobian, joint->constraint)
                       : first_block(&T->by.frictional_joint, j);
}

static void join_contact(nsdae_contact_islands *is, const nsdae_terms *T, int i)
{
  int anchor = block_of_contact(T, i), j = i * T->system->dims.nt;
  join_row(is->parent, &T->by.normal, i, anchor);
  for (int d = 1; d < nsdae_terms_differing(T->system); d++)
    join_row(is->parent, &T->by.tangent, j++, anchor);
}

/* ---- members */

int nsdae_island_of_contact(const nsdae_contact_islands *is, const nsdae_terms *T, int i)
{
  return is->of[is->blocks == 1 ? 0 : block_of_contact(T, i)];
}

int nsdae_island_of_row(const nsdae_contact_islands *is, const nsdae_terms *T, int i)
{
  return is->of[is->blocks == 1 ? 0 : first_block(&T->by.jacobian, i)];
}

int nsdae_island_of_joint(const nsdae_contact_islands *is, const nsdae_terms *T, int i)
{
  return is->of[is->blocks == 1 ? 0 : block_of_joint(T, is, i)];
}

static int of_block(const nsdae_contact_islands *is, const nsdae_terms *T, int b)
{
  (void)T;
  return is->of[b];
}

/* Lists members by counting, each from the numbers that it goes by. */
static void list_members(nsdae_contact_islands *is, nsdae_members *m, int count, const int *number,
                         int (*island_of)(const nsdae_contact_islands *, const nsdae_terms *, int),
                         const nsdae_terms *T)
{
  memset(m->first, 0, ((size_t)is->count + 2) * sizeof *m->first);
  for (int a = 0; a < count; a++) {
    int island = island_of(is, T, number ? number[a] : a);
    if (island >= 0) m->first[island + 2]++;
  }
  for (int i = 0; i < is->count; i++) m->first[i + 2] += m->first[i + 1];
  for (int a = 0; a < count; a++) {
    int i = number ? number[a] : a, island = island_of(is, T, i);
    if (island >= 0) m->of[m->first[island + 1]++] = i;
  }
}

void nsdae_contact_islands_find(nsdae_contact_islands *is, const nsdae_terms *T, int contacts,
                                const int *number)
{
  if (is->blocks == 1) {
    /* The block, rows and joints are listed since the layout. */
    is->count = contacts + is->rows + is->joints > 0;
    is->of[0] = is->count - 1;
    is->contact.first[1] = contacts;
    for (int a = 0; a < contacts; a++) is->contact.of[a] = number[a];
    return;
  }
  const nsdae_rows *J = &T->by.jacobian;
  memset(is->parent, -1, (size_t)is->blocks * sizeof *is->parent);
  for (int a = 0; a < contacts; a++) join_contact(is, T, number[a]);
  for (int i = 0; i < is->rows; i++) join_row(is->parent, J, i, first_block(J, i));
  for (int i = 0; i < is->joints; i++)
    join_row(is->parent, &T->by.frictional_joint, is->joint_number[i], block_of_joint(T, is, i));
  is->count = 0;
  for (int b = 0; b < is->blocks; b++) {
    int root = is->parent[b] < 0 ? -1 : nsdae_sets_root(is->parent, b);
    is->of[b] = root < 0 ? -1 : root == b ? is->count++ : is->of[root];
  }
  list_members(is, &is->block, is->blocks, NULL, of_block, T);
  list_members(is, &is->contact, contacts, number, nsdae_island_of_contact, T);
  list_members(is, &is->row, is->rows, NULL, nsdae_island_of_row, T);
  list_members(is, &is->joint, is->joints, NULL, nsdae_island_of_joint, T);
}
