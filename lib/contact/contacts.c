#include "contacts.h"

#include <float.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "dense.h"
#include "listed.h"
#include "slides.h"
#include "system_impl.h"

void nsdae_contacts_set(nsdae_contacts *c, const nsdae_system *system, nsdae_error *error,
                        const nsdae_accuracy *accuracy, int polygon_edges)
{
  c->system = system;
  c->error = error;
  nsdae_lcp_options_default(&c->lcp.options);
  c->lcp.accuracy = *accuracy;
  c->lcp.options.tol = nsdae_accuracy_tol(accuracy);
  c->lcp.accept = nsdae_accuracy_accept(accuracy, c->lcp.options.tol);
  nsdae_contacts_laws(c, polygon_edges);
}

/* Of contact i at any time: a slot may get one with friction. */
static double friction_most(const nsdae_system *s, int i)
{
  return s->tracked && s->dims.nt > 0 ? 1 : s->contact[i].mu;
}

void nsdae_contacts_laws(nsdae_contacts *c, int polygon_edges)
{
  const nsdae_system *s = c->system;
  c->part.coefficient = s->contact;
  c->part.m = s->dims.m;
  c->part.place = s->blocks.first;
  c->edges = polygon_edges;
  nsdae_law_edges(polygon_edges, c->lcp.edge);
  int least = nsdae_terms_most(s) < NSDAE_ANY_NUMBER ? 1 : nsdae_law_rows(s->dims.nt, 1, c->edges);
  if (c->rows_most < least) c->rows_most = least; /* never less: memory is laid by it */
  c->slides.count = 0;
  c->cones.most = c->cones.most > 0 ? s->dims.k : 0;
  for (int j = 0; j < s->dims.f; j++) c->slides.count += nsdae_system_joint_rubs(s, j);
  for (int i = 0; i < s->dims.k; i++) {
    nsdae_law law = nsdae_law_make(s->dims.nt, friction_most(s, i), polygon_edges, NULL);
    if (law.rows > c->rows_most) c->rows_most = law.rows;
    if (law.kind == NSDAE_CONE) c->cones.most = s->dims.k;
  }
  c->rows_in_all = nsdae_contacts_rows(s, polygon_edges);
}

long nsdae_contacts_rows(const nsdae_system *s, int polygon_edges)
{
  long rows = 0;
  for (int j = 0; j < s->dims.f; j++) rows += nsdae_system_joint_rubs(s, j) ? 3 : 0;
  for (int i = 0; i < s->dims.k; i++)
    rows += nsdae_law_rows(s->dims.nt, friction_most(s, i), polygon_edges);
  return rows;
}

/* The largest n that the solver has a workspace for. */
int nsdae_contacts_rows_limit(void)
{
  int low = 0, high = INT_MAX / 2, lwork, liwork;
  while (low < high) {
    int middle = low + (high - low + 1) / 2;
    if (nsdae_lcp_workspace(middle, &lwork, &liwork) == NSDAE_OK)
      low = middle;
    else
      high = middle - 1;
  }
  return low;
}

void nsdae_contacts_layout(nsdae_contacts *c, const nsdae_dims *dims, nsdae_arena *arena)
{
  long k = dims->k, n = dims->nv, f = c->slides.count;
  long columns = k * (1 + dims->nt) + f, rows = c->rows_in_all;
  if (rows > INT_MAX || nsdae_lcp_workspace((int)rows, &c->lcp.lwork, &c->lcp.liwork) < 0)
    arena->overflow = 1;
  c->active = NSDAE_ARENA_INTS(arena, k);
  c->law = nsdae_arena_take(arena, k, sizeof *c->law);
  c->part.reaction = NSDAE_ARENA_DOUBLES(arena, n);
  nsdae_arena_ints(arena, k + 1, (int **[]){&c->first_column, &c->first_row, NULL});
  nsdae_arena_doubles(arena, n * columns, (double **[]){&c->delassus.W, &c->delassus.U, NULL});
  c->delassus.D = NSDAE_ARENA_DOUBLES(arena, dims->m * columns);
  c->delassus.G = NSDAE_ARENA_DOUBLES(arena, columns * columns);
  c->lcp.A = NSDAE_ARENA_DOUBLES(arena, rows * rows);
  nsdae_arena_doubles(arena, rows, (double **[]){&c->lcp.b, &c->lcp.x, &c->lcp.y, NULL});
  c->lcp.basis = NSDAE_ARENA_INTS(arena, rows);
  nsdae_arena_doubles(
      arena, columns,
      (double **[]){&c->delassus.impulse, &c->delassus.impulse_size, &c->delassus.offset, NULL});
  c->lcp.work = NSDAE_ARENA_DOUBLES(arena, c->lcp.lwork);
  c->lcp.other = NSDAE_ARENA_DOUBLES(arena, 4 * rows);
  c->lcp.iwork = NSDAE_ARENA_INTS(arena, c->lcp.liwork);
  nsdae_arena_ints(arena, f,
                   (int **[]){&c->slides.number, &c->slides.constraint, &c->slides.place, NULL});
  nsdae_arena_doubles(arena, f ? columns * rows : 0, (double **[]){&c->map.Z, &c->map.GZ, NULL});
  c->map.z0 = NSDAE_ARENA_DOUBLES(arena, columns);
  c->map.offset = NSDAE_ARENA_DOUBLES(arena, columns);
  c->map.K = NSDAE_ARENA_DOUBLES(arena, f * rows);
  c->map.k0 = NSDAE_ARENA_DOUBLES(arena, f);
  c->map.Q = NSDAE_ARENA_DOUBLES(arena, f * f);
  c->map.D_S = NSDAE_ARENA_DOUBLES(arena, f * columns);
  c->map.pivot = NSDAE_ARENA_INTS(arena, f);
  c->slides.row = NSDAE_ARENA_INTS(arena, f + 1);
  c->slides.limit = NSDAE_ARENA_DOUBLES(arena, f);
  nsdae_cones_layout(&c->cones, k + f, columns + f, dims->m, arena);
  for (int j = 0, count = 0; c->slides.number && j < dims->f; j++) {
    if (!nsdae_system_joint_rubs(c->system, j)) continue;
    c->slides.constraint[count] = c->system->frictional_joint[j].constraint;
    c->slides.place[count] = count;
    c->slides.number[count++] = j;
  }
}

void nsdae_contacts_remember(nsdae_contacts *c, int *memory)
{
  c->warm.basis = memory;
  c->warm.slide_basis = memory + (size_t)c->system->dims.k * (size_t)c->rows_most;
}

void nsdae_contacts_place_slides(nsdae_contacts *c, int first)
{
  c->rows = first;
  for (int j = 0; j < c->slides.count; j++) {
    c->slides.row[j] = c->rows;
    c->rows += nsdae_slides_rows(c, j);
  }
}

static void begin(nsdae_contacts *c, nsdae_impulses *results)
{
  c->results = results;
  c->lcp.info = (nsdae_lcp_info){.outcome = NSDAE_OUTCOME_SOLVED};
  c->active_count = c->columns = c->rows = 0;
}

static void add_contact(nsdae_contacts *c, int i)
{
  int a = c->active_count++;
  c->law[a] = c->given ? c->given[i]
                       : nsdae_law_make(c->system->dims.nt, c->part.coefficient[i].mu, c->edges,
                                        c->lcp.edge);
  c->active[a] = i;
  c->first_column[a] = c->columns;
  c->first_row[a] = c->rows;
  c->columns += c->law[a].columns;
  c->rows += c->law[a].rows;
}

/* Those of the frictional joints come last. */
static void end(nsdae_contacts *c)
{
  c->first_column[c->active_count] = c->columns;
  c->first_row[c->active_count] = c->rows;
  c->columns += c->slides.count;
  nsdae_contacts_place_slides(c, c->rows);
}

void nsdae_contacts_close_marked(nsdae_contacts *c, const int *closed, nsdae_impulses *results)
{
  nsdae_impulses_clear(results, &c->system->dims);
  begin(c, results);
  for (int n = 0; n < c->system->dims.k; n++) {
    int i = nsdae_system_contact(c->system, n);
    if (closed[i]) add_contact(c, i);
  }
  end(c);
}

void nsdae_contacts_close_these(nsdae_contacts *c, int count, const int *contact,
                                nsdae_impulses *results)
{
  begin(c, results);
  for (int i = 0; i < count; i++) add_contact(c, contact[i]);
  end(c);
}

/* w_i + W_i^T v */
static inline double rate(const nsdae_contacts *c, const nsdae_rows *rows, const double *w, int i,
                          const double *v)
{
  const int *first = c->system->blocks.first;
  double sum = w[i];
  for (int p = rows->first[i]; p < rows->first[i + 1]; p++) {
    int b = rows->block[p];
    sum = nsdae_dot_from(sum, first[b + 1] - first[b], rows->value + rows->at[p],
                         v + c->part.place[b]);
  }
  return sum;
}

static inline void frictional_joint_velocities(const nsdae_contacts *c, const nsdae_terms *T,
                                               const double *v, double *velocity)
{
  for (int i = 0; i < c->slides.count; i++) {
    int j = c->slides.number[i];
    velocity[j] = rate(c, &T->by.frictional_joint, T->frictional_joint.w, j, v);
  }
}

/* v(+) by the columns of W, and by the rows of tangents without friction. */
static void velocities_after(nsdae_contacts *c, const nsdae_terms *T, int n, const double *v)
{
  nsdae_impulses *r = c->results;
  int nt = c->system->dims.nt;
  for (int a = 0; a < c->active_count; a++) {
    int i = c->active[a];
    const double *W = c->delassus.W + (size_t)c->first_column[a] * (size_t)n;
    r->after[i] = nsdae_dot_from(T->w_N[i], n, W, v);
    for (int l = 1, j = i * nt; l <= nt; l++, j++)
      r->after_t[j] = l < c->law[a].columns
                          ? nsdae_dot_from(T->w_T[j], n, W + (size_t)l * (size_t)n, v)
                          : rate(c, &T->by.tangent, T->w_T, j, v);
  }
  frictional_joint_velocities(c, T, v, r->slide_after);
}

void nsdae_contacts_approach(const nsdae_terms *T, int count, const int *contact, const double *v,
                             int impacts_only, nsdae_impulses *r)
{
  for (int a = 0; a < count; a++)
    if (!impacts_only || r->impact[contact[a]])
      nsdae_terms_contact_rates(T, contact[a], v, r->before, r->before_t);
}

void nsdae_contacts_before(nsdae_contacts *c, const nsdae_terms *T, const double *v,
                           int impacts_only)
{
  nsdae_contacts_approach(T, c->active_count, c->active, v, impacts_only, c->results);
  if (!impacts_only) frictional_joint_velocities(c, T, v, c->results->slide_before);
}

void nsdae_contacts_come(nsdae_contacts *c, const double *before)
{
  memcpy(c->results->before, before, (size_t)c->system->dims.k * sizeof *before);
}

/* Row i as a column of W. */
static void gather_column(const nsdae_contacts *c, const nsdae_rows *rows, int i, int n, double *to)
{
  const nsdae_blocks *blocks = &c->system->blocks;
  int p = rows->first[i];
  size_t bytes = (size_t)n * sizeof *to;
  if (rows->first[i + 1] == p + 1 && nsdae_blocks_size(blocks, rows->block[p]) == n) {
    memcpy(to, rows->value + rows->at[p], bytes);
    return;
  }
  memset(to, 0, bytes);
  nsdae_rows_gather(blocks, rows, i, c->part.place, to, 1);
}

/* W, one block of columns per closed contact: normal, then tangential where it has friction. */
static void gather_columns(nsdae_contacts *c, const nsdae_terms *terms, int columns_n)
{
  size_t n = (size_t)columns_n;
  int nt = c->system->dims.nt;
  for (int a = 0; a < c->active_count; a++) {
    int i = c->active[a];
    double *at = c->delassus.W + (size_t)c->first_column[a] * n;
    gather_column(c, &terms->by.normal, i, columns_n, at);
    for (int l = 1; l < c->law[a].columns; l++)
      gather_column(c, &terms->by.tangent, i * nt + l - 1, columns_n, at + (size_t)l * n);
  }
  double *slides = c->delassus.W + (size_t)(c->columns - c->slides.count) * n;
  for (int j = 0; j < c->slides.count; j++, slides += n) {
    double scale = nsdae_slides_beside(c, j).scale;
    gather_column(c, &terms->by.frictional_joint, c->slides.number[j], columns_n, slides);
    for (size_t l = 0; scale != 1 && l < n; l++) slides[l] *= scale;
  }
}

/* Where the constraints leave a column no motion, W_j = Phi_q^T D_j, its U_j = P W_j is rounding
 * and must not be taken for a mass of 1e17. */
static void clear_jammed(nsdae_contacts *c, const nsdae_terms *terms, const nsdae_kkt *kkt)
{
  const int n = kkt->n, m = kkt->m;
  const nsdae_rows *J = c->part.J ? c->part.J : &terms->by.jacobian;
  double *reaction = c->part.reaction;
  for (int j = 0; j < c->columns; j++) {
    const double *W = c->delassus.W + (size_t)j * (size_t)n,
                 *D = c->delassus.D + (size_t)j * (size_t)m;
    double largest = 0, left = 0;
    memset(reaction, 0, (size_t)n * sizeof *reaction);
    for (int i = 0; i < m; i++) {
      nsdae_rows_add(kkt->blocks, J, i, D[i], reaction);
      largest = fmax(largest, fabs(D[i]) * nsdae_rows_largest(kkt->blocks, J, i));
    }
    for (int i = 0; i < n; i++) {
      largest = fmax(largest, fabs(W[i]));
      left = fmax(left, fabs(W[i] - reaction[i]));
    }
    if (left <= 64 * DBL_EPSILON * largest)
      memset(c->delassus.U + (size_t)j * (size_t)n, 0, (size_t)n * sizeof *c->delassus.U);
  }
}

/* nsdae_kkt_solve with the record where the problem has it. */
static int solve_equations(const nsdae_contacts *c, const nsdae_terms *terms, const nsdae_kkt *kkt,
                           int nrhs, double *R, double *C)
{
  int status = nsdae_kkt_solve(kkt, nrhs, R, kkt->n, C, kkt->m);
  return status < 0 ? nsdae_terms_bad_equations(terms, c->error, "", kkt->m, status) : status;
}

static int delassus(nsdae_contacts *c, const nsdae_terms *terms, const nsdae_kkt *kkt)
{
  int n = kkt->n, m = kkt->m;
  memcpy(c->delassus.U, c->delassus.W, (size_t)n * (size_t)c->columns * sizeof *c->delassus.U);
  if (m > 0) memset(c->delassus.D, 0, (size_t)m * (size_t)c->columns * sizeof *c->delassus.D);
  int status = solve_equations(c, terms, kkt, c->columns, c->delassus.U, c->delassus.D);
  if (status < 0) return status;
  if (m > 0) clear_jammed(c, terms, kkt);
  nsdae_la_multiply_transposed(n, c->columns, c->columns, 1, c->delassus.W, n, c->delassus.U, n, 0,
                               c->delassus.G, c->columns);
  for (int j = 0, l = c->columns - c->slides.count; j < c->slides.count; j++, l++)
    c->delassus.G[(size_t)l * (size_t)(c->columns + 1)] += nsdae_slides_beside(c, j).compliance;
  return NSDAE_OK;
}

/* W^T v_free + w(+) + e v(-), in the order of the columns. */
static void offsets(nsdae_contacts *c, const nsdae_terms *terms, int n, const double *v_free)
{
  int nt = c->system->dims.nt;
  velocities_after(c, terms, n, v_free);
  for (int a = 0; a < c->active_count; a++) {
    int i = c->active[a];
    const nsdae_coefficients *e = &c->part.coefficient[i];
    double *at = c->delassus.offset + c->first_column[a];
    at[0] = c->results->after[i] + e->e_n * c->results->before[i];
    for (int j = 1; j < c->law[a].columns; j++)
      at[j] = c->results->after_t[i * nt + j - 1] + e->e_t * c->results->before_t[i * nt + j - 1];
  }
  c->slides.terms = 0;
  for (int j = 0; j < c->slides.count; j++) {
    const nsdae_joint_row beside = nsdae_slides_beside(c, j);
    double rate = c->results->slide_after[c->slides.number[j]],
           w = terms->frictional_joint.w[c->slides.number[j]];
    c->delassus.offset[c->columns - c->slides.count + j] = beside.scale * rate + beside.shift;
    c->slides.terms =
        fmax(c->slides.terms, beside.scale * (fabs(w) + fabs(rate - w)) + fabs(beside.shift));
  }
}

/* E_P^T G E_Q of two contacts into their block of A: in the plane, and of any. */
static void assemble_planar(const double *G, size_t ldg, double mu, double *A, size_t lda)
{
  for (size_t i = 0; i < 2; i++) {
    A[i] = G[i] - mu * G[i + ldg];
    A[i + lda] = G[i + ldg];
    A[i + 2 * lda] = 0;
  }
  A[2] = A[2 + lda] = A[2 + 2 * lda] = 0;
}

static void assemble_any(const nsdae_law *p, const nsdae_law *q, const double *G, size_t ldg,
                         double *A, size_t lda)
{
  double GE[NSDAE_LAW_COLUMNS][NSDAE_LAW_ROWS]; /* G E_Q */
  for (int i = 0; i < p->columns; i++) nsdae_law_times_impulse(q, G + i, ldg, GE[i]);
  for (int j = 0; j < q->rows; j++) {
    const double xi[NSDAE_LAW_COLUMNS] = {GE[0][j], p->columns > 1 ? GE[1][j] : 0,
                                          p->columns > 2 ? GE[2][j] : 0};
    nsdae_law_velocity(p, xi, A + (size_t)j * lda);
  }
}

/* The columns of A of a contact. */
static void assemble_columns(nsdae_contacts *c, int a)
{
  const nsdae_law *q = &c->law[a];
  size_t ldg = (size_t)c->columns, lda = (size_t)c->rows;
  const double *from = c->delassus.G + (size_t)c->first_column[a] * ldg;
  double *to = c->lcp.A + (size_t)c->first_row[a] * lda;
  for (int other = 0; other < c->active_count; other++) {
    const nsdae_law *p = &c->law[other];
    const double *G = from + c->first_column[other];
    double *A = to + c->first_row[other];
    if (p->kind == NSDAE_PLANAR && q->kind == NSDAE_PLANAR)
      assemble_planar(G, ldg, q->mu, A, lda);
    else
      assemble_any(p, q, G, ldg, A, lda);
  }
  nsdae_law_add_coupling(q, to + c->first_row[a], c->rows);
  nsdae_law_velocity(q, c->delassus.offset + c->first_column[a], c->lcp.b + c->first_row[a]);
}

/* Where none has friction E_P = E_Q = 1, and A is G. */
static void assemble(nsdae_contacts *c)
{
  size_t n = (size_t)c->columns;
  if (c->columns == c->active_count) {
    memcpy(c->lcp.A, c->delassus.G, n * n * sizeof *c->lcp.A);
    memcpy(c->lcp.b, c->delassus.offset, n * sizeof *c->lcp.b);
    return;
  }
  for (int a = 0; a < c->active_count; a++) assemble_columns(c, a);
}

/* The basis between a closed contact's place in the problem and its place in memory. */
static int *memory_of(const nsdae_contacts *c, int a)
{
  return c->warm.basis + (size_t)c->active[a] * (size_t)c->rows_most;
}

static void keep_basis(nsdae_contacts *c)
{
  for (int a = 0; a < c->active_count; a++)
    memcpy(memory_of(c, a), c->lcp.basis + c->first_row[a],
           (size_t)c->law[a].rows * sizeof *c->warm.basis);
  for (int j = 0; j < c->slides.count; j++)
    memcpy(c->warm.slide_basis + 3 * (size_t)c->slides.place[j], c->lcp.basis + c->slides.row[j],
           (size_t)nsdae_slides_rows(c, j) * sizeof *c->warm.basis);
}

static int unsolved(nsdae_contacts *c, double t, int status)
{
  char first[NSDAE_CALLED_SIZE];
  int contact = c->active_count > 0;
  if (contact)
    nsdae_system_called_contact(c->system, c->part.id, c->active[0], first);
  else
    nsdae_system_called(c->system, NSDAE_NAME_FRICTIONAL_JOINT, c->slides.number[0], first);
  nsdae_error_set(
      c->error, status, "nsdae_contacts", "",
      "contact problem of %d rows (first %s) at t = %g: %s, residual %.3g above %.3g; a "
      "smaller dt or less friction may help",
      c->rows, first, t, nsdae_status_message(status), c->lcp.info.residual, c->lcp.options.tol);
  return nsdae_error_at(
      c->error, status,
      contact ? nsdae_system_index(c->system, NSDAE_NAME_CONTACT, c->active[0]) : -1, t);
}

int nsdae_contacts_accept(nsdae_contacts *c, int status)
{
  if (status != NSDAE_E_LCP || !(c->lcp.info.residual <= c->lcp.accept)) return status;
  if (c->lcp.info.residual > c->lcp.options.tol) c->lcp.accepted = 1;
  return NSDAE_OK;
}

int nsdae_contacts_solve_lcp(nsdae_contacts *c)
{
  nsdae_lcp_problem problem = {.n = c->rows, .A = c->lcp.A, .lda = c->rows, .b = c->lcp.b};
  for (int a = 0; a < c->active_count; a++)
    memcpy(c->lcp.basis + c->first_row[a], memory_of(c, a),
           (size_t)c->law[a].rows * sizeof *c->warm.basis);
  for (int j = 0; j < c->slides.count; j++)
    memcpy(c->lcp.basis + c->slides.row[j], c->warm.slide_basis + 3 * (size_t)c->slides.place[j],
           (size_t)nsdae_slides_rows(c, j) * sizeof *c->warm.basis);
  int status =
      nsdae_lcp_solve_in(&problem, &c->lcp.options, c->lcp.basis, c->lcp.x, c->lcp.y, &c->lcp.info,
                         c->lcp.work, c->lcp.lwork, c->lcp.iwork, c->lcp.liwork);
  if (status == NSDAE_OK) keep_basis(c);
  return nsdae_contacts_accept(c, status);
}

/* A polygon's gamma is the slip speed; one of rounding size is none. */
static int mode_of(const nsdae_contacts *c, int a)
{
  const nsdae_law *law = &c->law[a];
  const double *x = c->lcp.x + c->first_row[a], *offset = c->delassus.offset + c->first_column[a];
  if (law->kind == NSDAE_CONE) return nsdae_cones_mode(c, a);
  int mode = nsdae_law_mode(law, x);
  double speed = 0;
  if (law->kind != NSDAE_POLYGON || mode != NSDAE_MODE_SLIP) return mode;
  for (int l = 0; l < law->columns; l++) speed = fmax(speed, fabs(offset[l]));
  return x[law->rows - 1] > c->lcp.options.tol * speed ? NSDAE_MODE_SLIP : NSDAE_MODE_STICK;
}

/* Lambda = E_Q x, and what the contact does. */
static void scatter(nsdae_contacts *c)
{
  int nt = c->system->dims.nt;
  for (int a = 0; a < c->active_count; a++) {
    int i = c->active[a];
    const nsdae_law *law = &c->law[a];
    const double *x = c->lcp.x + c->first_row[a];
    double *impulse = c->delassus.impulse + c->first_column[a];
    /* of the contact as a whole: so good is the solution of the LCP */
    double size = nsdae_law_impulse(law, x, impulse);
    for (int l = 0; l < law->columns; l++) c->delassus.impulse_size[c->first_column[a] + l] = size;
    c->results->normal[i] = impulse[0];
    for (int l = 1; l <= nt; l++)
      c->results->tangential[i * nt + l - 1] = l < law->columns ? impulse[l] : 0;
    c->results->mode[i] = mode_of(c, a);
  }
}

/* v += U Lambda, and to size how large the terms are. What cancels to rounding is zero: a body that
 * sticks has no velocity at all, and does not creep. */
static void add_velocity(const nsdae_contacts *c, int n, double *restrict size, double *restrict v)
{
  const double rounding = 32 * DBL_EPSILON;
  for (int i = 0; i < n; i++) size[i] = fabs(size[i]) + fabs(v[i]);
  for (int j = 0; j < c->columns; j++) {
    const double *restrict U = c->delassus.U + (size_t)j * (size_t)n;
    double impulse = c->delassus.impulse[j], impulse_size = c->delassus.impulse_size[j];
    for (int i = 0; i < n; i++) {
      v[i] += U[i] * impulse;
      size[i] += fabs(U[i]) * impulse_size;
    }
  }
  for (int i = 0; i < n; i++) v[i] = fabs(v[i]) <= rounding * size[i] ? 0 : v[i];
}

/* Lambda, and what each contact and frictional joint does, from G and the offsets. */
static int solve_impulses(nsdae_contacts *c, const double *lambda)
{
  int status = NSDAE_OK, cones = nsdae_cones_any(c);
  c->lcp.accepted = 0;
  if (cones)
    status = nsdae_cones_solve(c, lambda);
  else if (c->slides.count > 0)
    status = nsdae_slides_solve(c, lambda);
  else {
    assemble(c);
    status = nsdae_contacts_solve_lcp(c);
  }
  if (status < 0) return status;
  scatter(c);
  return NSDAE_OK;
}

int nsdae_contacts_solve(nsdae_contacts *c, const nsdae_terms *terms, const nsdae_kkt *kkt,
                         double *size, double *v, double *lambda)
{
  if (!nsdae_contacts_any(c)) return NSDAE_OK;
  gather_columns(c, terms, kkt->n);
  int status = delassus(c, terms, kkt);
  if (status < 0) return status;
  offsets(c, terms, kkt->n, v);
  status = solve_impulses(c, lambda);
  if (status < 0) return unsolved(c, nsdae_terms_time(terms), status);
  add_velocity(c, kkt->n, size, v);
  nsdae_add_product(kkt->m, c->columns, c->delassus.D, c->delassus.impulse, lambda);
  velocities_after(c, terms, kkt->n, v);
  return NSDAE_OK;
}

int nsdae_contacts_step(nsdae_contacts *c, const nsdae_terms *terms, const nsdae_kkt *kkt,
                        const double *r, double *v, double *size, double *lambda)
{
  size_t bytes = (size_t)kkt->n * sizeof *v;
  memcpy(v, r, bytes);
  int status = solve_equations(c, terms, kkt, 1, v, lambda);
  if (status < 0) return status;
  memcpy(size, kkt->m > 0 ? r : v, bytes);
  if (kkt->m > 0) nsdae_kkt_solve_mass(kkt, size);
  return nsdae_contacts_solve(c, terms, kkt, size, v, lambda);
}

double nsdae_contacts_work(const nsdae_contacts *c)
{
  return nsdae_impulses_work(c->results, c->system->dims.nt, c->active_count, c->active,
                             c->slides.count, c->slides.number);
}
