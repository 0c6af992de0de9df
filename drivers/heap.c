/* nsdae-heap: see models/heap.c. */
#include "heap.h"

int main(int argc, char **argv)
{
  return driver_main(&heap_model, argc, argv);
}
