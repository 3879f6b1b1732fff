/* Number of drives side by side in a block. */
#ifndef SENSORLESS_LANES_H
#define SENSORLESS_LANES_H

#define LANES 16

#endif
