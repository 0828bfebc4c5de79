#!/usr/bin/env bash
# What: two distributions, cm-ethernetip and ethernetip, install the same package `ethernetip`, and pip says nothing
# Packages:
#   pypi cm-ethernetip 0.1.0
# Date: 2026-11-29
# Meets: who installs an EtherNet/IP scanner by the name of its package
# Expected: cm-ethernetip has a package of another name, or pip reports the conflict
# Behavior:
#   After pip install cm-ethernetip the package ethernetip has a module client. pip install ethernetip replaces its
#   __init__.py without a word, pip check finds nothing broken, and what cm-ethernetip's users import is gone from it.
#   Uninstalling one of them then takes away the other's __init__.py.
# Scanrack: Uses neither; which clients are tried: see [clients of the tag servers](hmi-clients.md)
# Output:
#   []
#   0
#   ['CIP_FWD_OPEN_EXTENDED_STATUS_INVALID_CONFIGURATION_SIZE', 'CIP_FWD_OPEN_EXTENDED_STATUS_VENDOR_OR_PRODUCT_CODE_MISMATCH', 'CIP_OBJ_ASSEMBLY', 'CIP_OBJ_BASE_SWITCH']
#   No broken requirements found.
#   after the uninstall of one, the file of the other is None
. "$(dirname "$0")/lib.sh"
look='import ethernetip as e; print(sorted(n for n in vars(e) if n[0].isupper())[:4])'
observe python -c "$look"
pip install --quiet --disable-pip-version-check ethernetip==1.2.0 >install.log 2>&1
observe grep -ciE 'conflict|overwrit' install.log || true
observe python -c "$look"
observe pip check --disable-pip-version-check
pip uninstall --quiet --yes ethernetip >/dev/null 2>&1
observe python -c "import ethernetip; print('after the uninstall of one, the file of the other is', ethernetip.__file__)"
