"""Policies that were learnt elsewhere: read from files of others, and asked for actions.

A file of somebody else is data: nothing in it is executed. A description in JSON lies beside each
policy and states what it observes and what its actions mean.
"""
