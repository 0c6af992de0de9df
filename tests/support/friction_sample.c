/* Writes a seeded problem in its global and its local form, and one that no doubles solve to 1e-12.
 * usage: friction_sample GLOBAL LOCAL HEAVY */
#include <nsdae/nsdae.h>
#include <stdio.h>

#include "friction_families.h"

/* A body of 1 on one of 3e-7, pushed from the side; two bars hold the light one. They bear both
 * weights and differ from the contact by that of the light one, no multiple of their last digit. */
static int write_heavy(const char *path, nsdae_error *error)
{
  const int rows[] = {2}, size[] = {2, 2}, first[] = {0, 2, 3, 4}, block[] = {0, 1, 0, 0};
  const double mu[] = {0.5}, w[4] = {0}, M[] = {3e-7, 0, 0, 3e-7, 1, 0, 0, 1};
  const double f[] = {-3e-8, 9e-9, -0.1, 0.03};
  const double value[] = {-1, 0, 0, -1, 1, 0, 0, 1, 1, 0, 0, 1};
  const nsdae_friction_problem problem = {.contacts = 1,
                                          .bilateral = 2,
                                          .rows = rows,
                                          .mu = mu,
                                          .w = w,
                                          .blocks = 2,
                                          .size = size,
                                          .M = M,
                                          .f = f,
                                          .first = first,
                                          .block = block,
                                          .value = value};
  return nsdae_friction_write(path, &problem, NULL, NULL, error);
}

int main(int argc, char **argv)
{
  friction_sample s;
  friction_local local;
  nsdae_error error = {0};
  if (argc != 4) return 2;
  friction_sample_draw(&s, FRICTION_SPHERES, 60, 2);
  friction_sample_local(&s, &local);
  int status = nsdae_friction_write(argv[1], &s.problem, NULL, NULL, &error);
  if (status == NSDAE_OK)
    status = nsdae_friction_write(argv[2], &local.problem, NULL, NULL, &error);
  if (status == NSDAE_OK) status = write_heavy(argv[3], &error);
  if (status < 0) fprintf(stderr, "%s\n", error.text);
  friction_local_release(&local);
  friction_sample_release(&s);
  return status < 0;
}
