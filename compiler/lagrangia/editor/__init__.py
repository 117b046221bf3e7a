"""What an editor does with a text: its one layout, and what a language server answers while it is written.

Here belongs: what is done with text that people are writing, wrong or unfinished as it may be, without a run.
Not here: what a text means (language), what a scene is (compile); how a command is called.
"""
