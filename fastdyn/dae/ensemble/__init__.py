"""Ensembles of DAEs: the equations of each trajectory as a problem of the ensembles' loop."""
