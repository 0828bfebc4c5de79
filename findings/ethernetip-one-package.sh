#!/usr/bin/env bash
# what: two distributions, cm-ethernetip and ethernetip, install the same package `ethernetip`, without a warning from pip
# date: 2026-11-29
# meets: anyone who installs an EtherNet/IP scanner by the name of its package
# expected: cm-ethernetip has a package of another name, or pip reports the conflict
# behavior:
#   Both have a file ethernetip/__init__.py. Installing ethernetip over cm-ethernetip replaces that file without a
#   word, and pip check finds nothing broken. Uninstalling ethernetip takes the file away, so the package that
#   cm-ethernetip's users import has no __init__.py left, while cm-ethernetip still counts as installed.
# product: Installs neither; see the [tested clients of the tag servers](hmi-clients.md)
# output:
#   ['cm-ethernetip'] doc: EtherNet/IP and CIP protocol stack in pure Python.
#   pip names a conflict in 0 lines
#   ['cm-ethernetip', 'ethernetip'] doc: fast, simple packet creation and parsing.
#   No broken requirements found.
#   ['cm-ethernetip'] doc: none
folder=$(mktemp -d)
. "$(dirname "$0")/lib"
install cm-ethernetip==0.1.0
cat >look.py <<'PY'
from importlib.metadata import packages_distributions

import ethernetip

print(sorted(packages_distributions()["ethernetip"]), "doc:", (ethernetip.__doc__ or "none").splitlines()[0])
PY
observe python look.py
pip install --quiet --disable-pip-version-check ethernetip==1.2.0 >install.log 2>&1
echo "pip names a conflict in $(grep -ciE 'conflict|overwrit' install.log || true) lines" >>seen
observe python look.py
observe pip check --disable-pip-version-check
pip uninstall --quiet --yes ethernetip >install.log 2>&1
observe python look.py
