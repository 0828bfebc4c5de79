#!/usr/bin/env bash
# what: simple-pid jumps when it takes over from manual operation: set_auto_mode(True, last_output=50) continues with 70.5
# date: 2026-11-30
# meets: anyone who switches a heater or a valve from manual to automatic while it is away from the setpoint
# expected: 50 or nearly so, since last_output is documented as the value that the controller should start from
# behavior:
#   last_output becomes the integral alone, and the proportional term comes on top of it: with Kp 2 and an error of 10
#   the first output is 50 + 20 + the first step of the integral. At the setpoint there is no jump. Passing
#   last_output - Kp * error starts where the operator stopped.
# product: A PID that leaves manual operation continues from its present output: [instructions](instructions.md#instructions)
# output:
#   manual 50, process at 100, setpoint 100: 50.0
#   manual 50, process at 90, setpoint 100: 70.5
#   manual 50, process at 120, setpoint 100: 9.0
#   manual 50, process at 90, setpoint 100, last_output 50 - Kp * error: 50.5
folder=$(mktemp -d)
. "$(dirname "$0")/lib"
install simple-pid==2.0.1
observe python - <<'PY'
from simple_pid import PID

KP, KI, SETPOINT, MANUAL = 2, 0.5, 100, 50


def take_over(process, last_output):
    pid = PID(KP, KI, 0, setpoint=SETPOINT, sample_time=None, output_limits=(0, 100), auto_mode=False)
    pid.set_auto_mode(True, last_output=last_output)
    return pid(process, dt=0.1)


for process in (100, 90, 120):
    print(f"manual {MANUAL}, process at {process}, setpoint {SETPOINT}:", take_over(process, MANUAL))
corrected = MANUAL - KP * (SETPOINT - 90)
print(f"manual {MANUAL}, process at 90, setpoint {SETPOINT}, last_output {MANUAL} - Kp * error:", take_over(90, corrected))
PY
