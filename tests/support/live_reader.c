/* Reads a trajectory while another process writes it (HDF5's SWMR mode); exit 0 when it finds at
 * least a thousand records. */
#include <hdf5.h>
#include <stdio.h>

int main(int argc, char **argv)
{
  hsize_t rows = 0;
  if (argc != 2) return 2;
  hid_t file = H5Fopen(argv[1], H5F_ACC_RDONLY | H5F_ACC_SWMR_READ, H5P_DEFAULT);
  if (file < 0) return 3;
  hid_t set = H5Dopen2(file, "/time", H5P_DEFAULT), space = H5Dget_space(set);
  H5Sget_simple_extent_dims(space, &rows, NULL);
  H5Sclose(space);
  H5Dclose(set);
  H5Fclose(file);
  return rows >= 1000 ? 0 : 1;
}
