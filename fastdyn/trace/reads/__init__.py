"""The record of what a traced function reads from outside, and the program that reads it again."""
