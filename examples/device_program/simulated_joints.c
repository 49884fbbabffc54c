/* A program that moves an arm of a cell, here one that it simulates: docs/how-to/move-an-arm-with-your-program.md. It
 * uses Cyclone DDS, and types that idlc makes from Hecaton's IDL files. Replace `joints_*` by the protocol of your
 * robot.
 *
 * usage: simulated_joints DOMAIN CELL ARM POSITION...
 *
 * DOMAIN and CELL are `network.domain` and `name` of the cell file; POSITION is where each joint stands at first [rad |
 * m]. */

#include <dds/dds.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "device.h"

enum { kMostJoints = hecaton_msg_MAX_JOINTS };
static const double kPeriod = 0.004;      /* of the loop [s] */
static const double kFastest = 4.0;       /* of the simulated joints [rad/s] */
static const double kDeceleration = 10.0; /* with which they brake [rad/s^2] */

static volatile sig_atomic_t ended = 0;

static void end(int signal_number) {
  (void)signal_number;
  ended = 1;
}

static double now(void) {
  struct timespec time;
  clock_gettime(CLOCK_MONOTONIC, &time);
  return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

static void check(dds_entity_t entity, const char* what) {
  if (entity >= 0) return;
  fprintf(stderr, "simulated_joints: %s: %s\n", what, dds_strretcode(-entity));
  exit(1);
}

/* The simulated robot. */
struct Joints {
  int count;
  double q[kMostJoints];
  double qd[kMostJoints];
};

/* Each joint moves to its set-point in one period, but no faster than it can. */
static void joints_follow(struct Joints* joints, const double* set_point) {
  for (int i = 0; i < joints->count; ++i) {
    joints->qd[i] = fmax(-kFastest, fmin(kFastest, (set_point[i] - joints->q[i]) / kPeriod));
    joints->q[i] += joints->qd[i] * kPeriod;
  }
}

static void joints_brake(struct Joints* joints) {
  for (int i = 0; i < joints->count; ++i) {
    const double slower = fmax(0.0, fabs(joints->qd[i]) - kDeceleration * kPeriod);
    joints->qd[i] = copysign(slower, joints->qd[i]);
    joints->q[i] += joints->qd[i] * kPeriod;
  }
}

/* Best effort, the newest sample only, in the partition CELL/ARM. */
static void open_topics(dds_entity_t participant, const char* cell, const char* arm, dds_entity_t* commands,
                        dds_entity_t* states) {
  char partition[256];
  snprintf(partition, sizeof partition, "%s/%s", cell, arm);
  dds_qos_t* qos = dds_create_qos();
  dds_qset_partition1(qos, partition);
  dds_qset_reliability(qos, DDS_RELIABILITY_BEST_EFFORT, 0);
  dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, 1);
  const dds_entity_t subscriber = dds_create_subscriber(participant, qos, NULL);
  const dds_entity_t publisher = dds_create_publisher(participant, qos, NULL);
  check(subscriber, "subscriber");
  check(publisher, "publisher");
  *commands = dds_create_reader(
      subscriber, dds_create_topic(participant, &hecaton_msg_DeviceCommand_desc, "hecaton/DeviceCommand", NULL, NULL),
      qos, NULL);
  *states = dds_create_writer(
      publisher, dds_create_topic(participant, &hecaton_msg_DeviceState_desc, "hecaton/DeviceState", NULL, NULL), qos,
      NULL);
  check(*commands, "hecaton/DeviceCommand");
  check(*states, "hecaton/DeviceState");
  dds_delete_qos(qos);
}

/* What the driver wants now. */
struct Order {
  double until; /* follow `set_point` until this time of now(); earlier than now: brake */
  double set_point[kMostJoints];
  uint64_t session;
  uint64_t sequence_number;
};

static void take(dds_entity_t commands, const char* arm, int joints, struct Order* order) {
  void* samples[1] = {NULL};
  dds_sample_info_t info[1];
  const dds_return_t count = dds_take(commands, samples, info, 1, 1);
  if (count > 0 && info[0].valid_data) {
    const hecaton_msg_DeviceCommand* command = samples[0];
    const int whole = command->q._length == (uint32_t)joints;
    if (command->schema == hecaton_msg_SCHEMA_VERSION && strcmp(command->arm, arm) == 0) {
      order->until = 0.0;
      if (command->task == hecaton_msg_DEVICE_FOLLOW && whole) {
        order->until = now() + command->valid_for;
        memcpy(order->set_point, command->q._buffer, sizeof(double) * (size_t)joints);
      }
      order->session = command->session;
      order->sequence_number = command->sequence_number;
    }
  }
  if (count > 0) dds_return_loan(commands, samples, count);
}

static void report(dds_entity_t states, char* arm, struct Joints* joints, const struct Order* order) {
  hecaton_msg_DeviceState state;
  memset(&state, 0, sizeof state);
  state.schema = hecaton_msg_SCHEMA_VERSION;
  state.arm = arm;
  state.session = order->session;
  state.sequence_number = order->sequence_number;
  state.q._buffer = joints->q;
  state.qd._buffer = joints->qd;
  state.q._length = state.q._maximum = state.qd._length = state.qd._maximum = (uint32_t)joints->count;
  state.speed_scaling = 1.0;
  state.tracking_delay = kPeriod;
  state.mode = hecaton_msg_DEVICE_READY;
  state.text = "";
  dds_write(states, &state);
}

int main(int argc, char** argv) {
  if (argc < 5 || argc - 4 > kMostJoints) {
    fprintf(stderr, "usage: simulated_joints DOMAIN CELL ARM POSITION...\n");
    return 2;
  }
  signal(SIGINT, end);
  signal(SIGTERM, end);
  const dds_entity_t participant = dds_create_participant((dds_domainid_t)atoi(argv[1]), NULL, NULL);
  check(participant, "domain");
  dds_entity_t commands = 0;
  dds_entity_t states = 0;
  open_topics(participant, argv[2], argv[3], &commands, &states);

  struct Joints joints = {.count = argc - 4};
  for (int i = 0; i < joints.count; ++i) joints.q[i] = atof(argv[4 + i]);
  struct Order order = {0};
  double next = now();
  while (!ended) {
    take(commands, argv[3], joints.count, &order);
    if (now() < order.until) {
      joints_follow(&joints, order.set_point);
    } else {
      joints_brake(&joints);
    }
    report(states, argv[3], &joints, &order);
    next = fmax(next + kPeriod, now()); /* no burst after a pause */
    const struct timespec until = {(time_t)next, (long)(1e9 * fmod(next, 1.0))};
    clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, NULL);
  }
  dds_delete(participant);
  return 0;
}
