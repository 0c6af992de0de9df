/* Corners of what a body's polygon is made of. */
#ifndef NSDAE_DRIVER_OUTLINE_H
#define NSDAE_DRIVER_OUTLINE_H

enum { OUTLINE_BOX = 4 };

/* Of a rectangle about (x, y), counter-clockwise, as nsdae_body has them. */
static inline void outline_box(double x, double y, double width, double height,
                               double corner[3 * OUTLINE_BOX])
{
  static const double side[OUTLINE_BOX][2] = {{-0.5, -0.5}, {0.5, -0.5}, {0.5, 0.5}, {-0.5, 0.5}};
  for (int i = 0; i < OUTLINE_BOX; i++) {
    corner[3 * i] = x + side[i][0] * width;
    corner[3 * i + 1] = y + side[i][1] * height;
    corner[3 * i + 2] = 0;
  }
}

#endif
