/* missing PART...: what a library without these parts (HDF5, SUNDIALS, Qhull, Fortran) answers to
 * who needs one. */
#include <nsdae/nsdae.h>
#include <stdio.h>
#include <string.h>

static int one(double t, const double *q, double *M, int ldm, void *user)
{
  (void)t, (void)q, (void)ldm, (void)user;
  M[0] = 1;
  return 0;
}

static int none(double t, const double *q, const double *v, double *F, void *user)
{
  (void)t, (void)q, (void)v, (void)F, (void)user;
  return 0;
}

static int is_named(const char *part, int argc, char **argv)
{
  for (int i = 1; i < argc; i++)
    if (!strcmp(argv[i], part)) return 1;
  return 0;
}

int main(int argc, char **argv)
{
  const int no_file = is_named("HDF5", argc, argv), no_ida = is_named("SUNDIALS", argc, argv);
  const nsdae_dims dims = {.nq = 1};
  const nsdae_trajectory_info info = {.model = "none"};
  nsdae_sim_options options;
  nsdae_system *system;
  nsdae_sim *sim;
  nsdae_trajectory *file = NULL;
  nsdae_error error;
  nsdae_system_create(&dims, &system, NULL);
  nsdae_system_set_mass(system, one);
  nsdae_system_set_force(system, none);

  nsdae_sim_create(system, NULL, &sim, NULL);
  int made = nsdae_trajectory_create(sim, "missing.h5", &info, &file, &error);
  if (made < 0) printf("%s\n", error.text);
  nsdae_trajectory_close(&file, NSDAE_OK, NULL);
  remove("missing.h5");
  nsdae_sim_destroy(&sim);

  nsdae_sim_options_default(&options);
  options.method = NSDAE_METHOD_PENALTY;
  options.integrator = NSDAE_INTEGRATOR_IDA;
  int ida = nsdae_sim_create(system, &options, &sim, &error);
  if (ida < 0) printf("%s\n", error.text);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  const double point[12] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
  const nsdae_solid hull = {.shape = NSDAE_SHAPE_POLYHEDRON, .points = 4, .point = point};
  double triangle[36];
  int hulls = nsdae_solid_triangles(&hull, triangle, &error);
  if (hulls < 0) printf("%s\n", error.text);
  return hulls != (is_named("Qhull", argc, argv) ? NSDAE_E_UNSUPPORTED : 4) ||
         made != (no_file ? NSDAE_E_UNSUPPORTED : NSDAE_OK) ||
         ida != (no_ida ? NSDAE_E_UNSUPPORTED : NSDAE_OK);
}
